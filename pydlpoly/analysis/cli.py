"""``pydlpoly analyse``: quantities of a trajectory on the terminal, in files and as a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from pydlpoly.analysis.bilayer import BilayerThickness
from pydlpoly.analysis.bonds import BondAngles, BondLengths, terms_of
from pydlpoly.analysis.chains import ChainDimensions
from pydlpoly.analysis.clusters import ClusterSizes
from pydlpoly.analysis.density import DensityProfile
from pydlpoly.analysis.frames import Analysis, analyse
from pydlpoly.analysis.lamellae import LamellarOrder
from pydlpoly.analysis.molecules import Molecules, molecules_of
from pydlpoly.analysis.msd import MeanSquareDisplacement
from pydlpoly.analysis.order import OrientationalOrder
from pydlpoly.analysis.profile import BinnedProfiles, Profile
from pydlpoly.analysis.profile_plot import plot_table
from pydlpoly.analysis.rdf import RadialDistribution
from pydlpoly.analysis.report import Curve, Number
from pydlpoly.analysis.structure_factor import StructureFactor
from pydlpoly.analysis.vaf import VelocityAutocorrelation
from pydlpoly.analysis.writing import check_output, draw, table_text, write_map, write_results
from pydlpoly.errors import InputError
from pydlpoly.formats.binned_table import is_binned, read_binned
from pydlpoly.scene import Scene, load


def analyse_command(
    source: Annotated[
        Path,
        typer.Argument(help="A trajectory, or a folder with HISTORY (and FIELD, for molecules); or PROFILE or MAP."),
    ],
    *,
    rdf: Annotated[bool, typer.Option("--rdf", help="Radial distributions of all pairs of species.")] = False,
    between: Annotated[bool, typer.Option("--between", help="With --rdf: without pairs inside molecules.")] = False,
    density: Annotated[str | None, typer.Option(help="x, y or z: density profiles along this cell vector.")] = None,
    centre: Annotated[str | None, typer.Option(help="With --density: the species that stays in the middle.")] = None,
    profile: Annotated[
        str | None, typer.Option(help="x, y, z, or two of them: densities, flow and temperature in bins.")
    ] = None,
    bins: Annotated[int, typer.Option(min=1, help="With --profile: number of bins along each axis.")] = 100,
    msd: Annotated[bool, typer.Option("--msd", help="Mean-square displacements, diffusion coefficients.")] = False,
    vaf: Annotated[bool, typer.Option("--vaf", help="Velocity autocorrelations, diffusion coefficients.")] = False,
    chains: Annotated[bool, typer.Option("--chains", help="End-to-end distances and radii of gyration.")] = False,
    bonds: Annotated[bool, typer.Option("--bonds", help="Distributions of bond lengths and angles.")] = False,
    structure_factor: Annotated[bool, typer.Option("--structure-factor", help="Static structure factor.")] = False,
    clusters: Annotated[float | None, typer.Option(help="Sizes of clusters by distances up to this one.")] = None,
    order: Annotated[bool, typer.Option("--order", help="Orientational order of the molecules.")] = False,
    lamellae: Annotated[str | None, typer.Option(help="Lamellar order of this species.")] = None,
    bilayer: Annotated[str | None, typer.Option(help="HEAD,TAIL: thickness of a bilayer across z.")] = None,
    species: Annotated[str | None, typer.Option(help="Species, with commas, of clusters and S(q).")] = None,
    bin_width: Annotated[float, typer.Option(help="Width of a bin of g(r).")] = 0.05,
    reach: Annotated[float | None, typer.Option(help="Largest r of g(r) (default: half the cell).")] = None,
    longest: Annotated[float | None, typer.Option(help="Largest t of MSD and VAF (default: a quarter).")] = None,
    fit: Annotated[str | None, typer.Option(help="FROM:TO: times of the line through the MSD.")] = None,
    start: Annotated[int, typer.Option(min=0, help="Frames to leave out at the beginning.")] = 0,
    every: Annotated[int, typer.Option(min=1, help="Take every so many frames.")] = 1,
    scene: Annotated[Path | None, typer.Option(help="Folder with CONTROL, FIELD and CONFIG.")] = None,
    output: Annotated[Path | None, typer.Option(help="Write numbers and curves (.csv or .npz).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the curves (.png, .svg, .pdf); needs matplotlib.")] = None,
) -> None:
    """Compute quantities of a trajectory, with standard errors from averages over blocks of frames."""
    if is_binned(source):
        if profile is not None or density is not None or rdf or msd or vaf:
            raise typer.BadParameter(f"{source} holds averages already; leave out what they are computed by")
        show_binned(BinnedProfiles(read_binned(source)), output, plot)
        return
    history = source / "HISTORY" if source.is_dir() else source
    topology = _Topology(scene if scene is not None else source if source.is_dir() else None)
    chosen = tuple(species.split(",")) if species else ()
    makers: list[tuple[bool, Callable[[], Sequence[Analysis[Any]]]]] = [
        (rdf, lambda: [_radial(bin_width, reach, topology if between else None)]),
        (density is not None, lambda: [DensityProfile(density or "z", centre=centre)]),
        (profile is not None, lambda: [_profile(profile or "z", bins, topology)]),
        (msd, lambda: [MeanSquareDisplacement(longest=longest, fit=_range(fit))]),
        (vaf, lambda: [VelocityAutocorrelation(longest=longest)]),
        (chains, lambda: [ChainDimensions(topology.chains())]),
        (bonds, partial(_bonds, topology)),
        (structure_factor, lambda: [StructureFactor(species=chosen)]),
        (clusters is not None, lambda: [ClusterSizes(clusters or 0.0, species=chosen)]),
        (order, lambda: [OrientationalOrder(topology.chains())]),
        (lamellae is not None, lambda: [LamellarOrder(lamellae or "")]),
        (bilayer is not None, lambda: [_bilayer(bilayer or "")]),
    ]
    if not any(asked for asked, _ in makers):
        raise typer.BadParameter("say what to compute, for example --rdf --msd; --help lists all")
    if output is not None:
        check_output(output)
    if profile is not None and len(profile) > 1 and sum(asked for asked, _ in makers) > 1:
        raise typer.BadParameter("a map is written and drawn alone; ask for the others apart", param_hint="--profile")
    analyses = [one for asked, make in makers if asked for one in make()]
    count = analyse(history, *analyses, start=start, every=every)
    if count == 0:
        raise InputError(f"there are no frames to analyse after the first {start}", path=str(history))
    results = [one.result() for one in analyses]
    reduced = topology.reduced
    if profile is not None and len(profile) > 1:
        typer.echo(f"{count} frames of {history}")
        show_binned(_plain_table(results[0], reduced), output, plot)
        return
    numbers = [_plain(number, reduced) for result in results for number in result.numbers()]
    curves = [_plain_curve(curve, reduced) for result in results for curve in result.curves()]
    typer.echo(f"{count} frames of {history}")
    typer.echo(table_text(numbers))
    if output is not None:
        write_results(output, numbers, curves)
    if plot is not None:
        draw(plot, curves)


def show_binned(result: BinnedProfiles, output: Path | None, plot: Path | None) -> None:
    """Print the numbers of averages in bins, and write and draw them where that is asked for."""
    if output is not None:
        check_output(output)
    typer.echo(table_text(result.numbers()))
    if output is not None and len(result.table.axes) > 1:
        write_map(output, result.table)
    elif output is not None:
        write_results(output, result.numbers(), result.curves())
    if plot is not None:
        plot_table(result.table, plot)


def _plain_table(result: BinnedProfiles, reduced: bool) -> BinnedProfiles:
    return BinnedProfiles(replace(result.table, units={})) if reduced else result


class _Topology:
    """The scene beside a trajectory, read when something needs it."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._scene: Scene | None = None

    @property
    def scene(self) -> Scene:
        if self._folder is None:
            raise InputError("molecules are needed: give the folder of CONTROL, FIELD and CONFIG with --scene")
        if self._scene is None:
            self._scene = load(self._folder)
        return self._scene

    @property
    def known(self) -> bool:
        """Whether there is a scene to ask."""
        return self._scene is not None or (self._folder is not None and (self._folder / "FIELD").is_file())

    @property
    def reduced(self) -> bool:
        """Whether FIELD's units are reduced; without a scene lengths and times are those of the file."""
        return self.known and self.scene.units.reduced

    def chains(self) -> list[Molecules]:
        return [one for one in molecules_of(self.scene).values() if one.beads.shape[1] > 1]


def _profile(axes: str, bins: int, topology: _Topology) -> Profile:
    if topology.known:
        return Profile(axes, bins=bins, reduced=topology.reduced)
    typer.echo("no kinetic temperature: its unit is FIELD's; name the folder of FIELD with --scene", err=True)
    return Profile(axes, bins=bins, without=("kinetic_temperature",))


def _radial(width: float, reach: float | None, topology: _Topology | None) -> RadialDistribution:
    return RadialDistribution(bin_width=width, reach=reach, between=topology.chains() if topology else ())


def _bonds(topology: _Topology) -> list[Analysis[Any]]:
    lengths, angles = (terms_of(topology.scene, kind) for kind in ("bond", "angle"))
    return [BondLengths(lengths), *([BondAngles(angles)] if angles else [])]


def _range(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    try:
        low, high = (float(word) for word in text.split(":"))
    except ValueError:
        raise typer.BadParameter(f"expected FROM:TO, found '{text}'", param_hint="--fit") from None
    return low, high


def _bilayer(text: str) -> BilayerThickness:
    words = text.split(",")
    if len(words) != 2:
        raise typer.BadParameter(f"expected HEAD,TAIL, found '{text}'", param_hint="--bilayer")
    return BilayerThickness(*words)


def _plain(number: Number, reduced: bool) -> Number:
    return replace(number, unit="") if reduced and number.unit != "°" else number


def _plain_curve(curve: Curve, reduced: bool) -> Curve:
    if not reduced:
        return curve
    labels = [label if "°" in label else label.split(" (")[0] for label in (curve.x_label, curve.y_label)]
    return replace(curve, x_label=labels[0], y_label=labels[1])
