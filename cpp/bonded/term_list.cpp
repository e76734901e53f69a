// The templated loops over bonded terms: one loop for each kind, instantiated for every law of the registry.
#include "bonded/term_list.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "bonded/registry.hpp"

namespace dlpoly::bonded {

namespace {

template <class Law>
class TermListOf final : public TermList {
    static constexpr std::size_t beads = beads_of_kind[index(Law::info.kind)];

    struct Term {
        std::array<std::uint32_t, beads> bead;
        std::uint32_t law;
    };

  public:
    [[nodiscard]] const LawInfo& info() const noexcept override { return Law::info; }
    [[nodiscard]] std::size_t size() const noexcept override { return terms_.size(); }

    Magnitude set_parameters(std::span<const double> parameters, double thermal_energy) override {
        laws_.push_back(Law(parameters));
        return magnitude(laws_.back(), thermal_energy);
    }

    void add(const std::uint32_t* bead) override {
        Term term{};
        std::copy_n(bead, beads, term.bead.begin());
        term.law = static_cast<std::uint32_t>(laws_.size() - 1);
        terms_.push_back(term);
    }

    void partition(std::span<const std::uint32_t> bounds) override {
        const auto part_of = [&](std::uint32_t bead) {
            return static_cast<std::size_t>(std::upper_bound(bounds.begin(), bounds.end(), bead) - bounds.begin() - 1);
        };
        const std::size_t parts = bounds.size() - 1;
        const auto owner = [&](const Term& term) {
            const auto [low, high] = std::minmax_element(term.bead.begin(), term.bead.end());
            const std::size_t part = part_of(*low);
            return part == part_of(*high) ? part : parts;
        };
        std::stable_sort(terms_.begin(), terms_.end(),
                         [&](const Term& a, const Term& b) { return owner(a) < owner(b); });
        start_.assign(parts + 2, terms_.size());
        for (std::size_t k = terms_.size(); k-- > 0;) {
            start_[owner(terms_[k])] = k;
        }
        for (std::size_t part = parts + 1; part-- > 0;) {
            start_[part] = std::min(start_[part], start_[part + 1]);
        }
    }

    void evaluate(std::size_t part, const Places& places, Worker& worker) const override {
        for (std::size_t k = start_[part]; k < start_[part + 1]; ++k) {
            const Term& term = terms_[k];
            const Law& law = laws_[term.law];
            Failure failure{&Law::info, false, 0.0, {}};
            std::copy(term.bead.begin(), term.bead.end(), failure.beads.begin());
            if (!evaluate_term(law, term.bead, places, worker, failure)) {
                worker.fail(failure);
            }
        }
    }

    void add_curvature(std::size_t first, std::size_t last, const Places& places, std::span<const std::uint8_t> frozen,
                       double force_scale, CurvatureSum& sum) const override {
        constexpr double shift = 1e-5;
        std::array<std::uint32_t, beads> own{};
        for (std::size_t b = 0; b < beads; ++b) {
            own[b] = static_cast<std::uint32_t>(b);
        }
        std::array<double, 3 * beads> position{};
        std::array<double, 3 * beads> anchor{};
        const Places local{places.image, position.data(), anchor.data()};
        const Request request{Vector3::Constant(force_scale), 0.0, false};
        for (std::size_t k = first; k < last; ++k) {
            const Term& term = terms_[k];
            const Law& law = laws_[term.law];
            for (std::size_t b = 0; b < beads; ++b) {
                const Vector3 place = places.position(term.bead[b]);
                std::copy_n(place.data(), 3, &position[3 * b]);
                if constexpr (Law::info.kind == Kind::tether) {
                    const Vector3 held = places.anchor(term.bead[b]);
                    std::copy_n(held.data(), 3, &anchor[3 * b]);
                }
            }
            double trace = 0.0;
            for (std::size_t c = 0; c < 3 * beads; ++c) {
                if (frozen[term.bead[c / 3]] != 0) {
                    continue;
                }
                const double at = position[c];
                for (const double sign : {1.0, -1.0}) {
                    std::array<std::int64_t, 3 * beads> force{};
                    Worker worker(request, force.data());
                    Failure failure{&Law::info, false, 0.0, {}};
                    position[c] = at + sign * shift;
                    if (!evaluate_term(law, own, local, worker, failure) || worker.largest() >= 1.0) {
                        sum.lost = true;
                        return;
                    }
                    trace -= sign * static_cast<double>(force[c]);
                }
                position[c] = at;
            }
            sum.add(trace / (force_scale * 2.0 * shift));
        }
    }

  private:
    // A vector from one bead to another, false (and its length in `failure`) when its image is not certain.
    static bool separation(const Places& places, std::uint32_t to, std::uint32_t from, Vector3& vector,
                           Failure& failure) {
        vector = places.position(to) - places.position(from);
        return certain(places, vector, failure);
    }

    static bool certain(const Places& places, Vector3& vector, Failure& failure) {
        if (places.image.shorten(vector)) {
            return true;
        }
        failure.too_long = true;
        failure.length = vector.norm();
        return false;
    }

    static bool evaluate_term(const Law& law, const std::array<std::uint32_t, beads>& bead, const Places& places,
                              Worker& worker, Failure& failure) {
        if constexpr (Law::info.kind == Kind::bond) {
            return bond(law, bead, places, worker, failure);
        } else if constexpr (Law::info.kind == Kind::angle) {
            return angle(law, bead, places, worker, failure);
        } else if constexpr (Law::info.kind == Kind::dihedral) {
            return dihedral(law, bead, places, worker, failure);
        } else if constexpr (Law::info.kind == Kind::inversion) {
            return inversion(law, bead, places, worker, failure);
        } else {
            return tether(law, bead, places, worker, failure);
        }
    }

    static bool bond(const Law& law, const std::array<std::uint32_t, 2>& bead, const Places& places, Worker& worker,
                     Failure& failure)
        requires(Law::info.kind == Kind::bond)
    {
        Vector3 d;
        if (!separation(places, bead[0], bead[1], d, failure)) {
            return false;
        }
        failure.length = d.norm();
        const Value value = law(failure.length);
        return std::isfinite(value.slope) &&
               worker.add<2>(index(Kind::bond), bead, value.energy, {-value.slope * direction(d)}, {d});
    }

    static bool tether(const Law& law, const std::array<std::uint32_t, 1>& bead, const Places& places, Worker& worker,
                       Failure& failure)
        requires(Law::info.kind == Kind::tether)
    {
        Vector3 d = places.position(bead[0]) - places.anchor(bead[0]);
        if (!certain(places, d, failure)) {
            return false;
        }
        failure.length = d.norm();
        const Value value = law(failure.length);
        return std::isfinite(value.slope) &&
               worker.add<1>(index(Kind::tether), bead, value.energy, {-value.slope * direction(d)}, {d});
    }

    static bool angle(const Law& law, const std::array<std::uint32_t, 3>& bead, const Places& places, Worker& worker,
                      Failure& failure)
        requires(Law::info.kind == Kind::angle)
    {
        Vector3 a, b;
        if (!separation(places, bead[0], bead[1], a, failure) || !separation(places, bead[2], bead[1], b, failure)) {
            return false;
        }
        const Angle angle(a, b);
        const AngleValue value = law(angle.value, angle.first, angle.second);
        return worker.add<3>(index(Kind::angle), {bead[0], bead[2], bead[1]}, value.energy,
                             {-value.by_angle * angle.by_first - value.by_first * angle.e_first,
                              -value.by_angle * angle.by_second - value.by_second * angle.e_second},
                             {a, b});
    }

    static bool dihedral(const Law& law, const std::array<std::uint32_t, 4>& bead, const Places& places, Worker& worker,
                         Failure& failure)
        requires(Law::info.kind == Kind::dihedral)
    {
        Vector3 f, g, h;
        if (!separation(places, bead[0], bead[1], f, failure) || !separation(places, bead[1], bead[2], g, failure) ||
            !separation(places, bead[3], bead[2], h, failure)) {
            return false;
        }
        const Dihedral dihedral(f, g, h);
        const Value value = law(dihedral.value);
        return worker.add<4>(
            index(Kind::dihedral), {bead[0], bead[2], bead[3], bead[1]}, value.energy,
            {-value.slope * dihedral.by_f, value.slope * (dihedral.by_g + dihedral.by_h), -value.slope * dihedral.by_h},
            {f, -g, h - g});
    }

    // Bead 0 is the centre; angles are averaged over the three choices of the vector that leaves the plane.
    static bool inversion(const Law& law, const std::array<std::uint32_t, 4>& bead, const Places& places,
                          Worker& worker, Failure& failure)
        requires(Law::info.kind == Kind::inversion)
    {
        std::array<Vector3, 3> arm;
        if constexpr (Law::info.height) {
            // From bead 1, which lies in the plane, to the centre and to the plane's other beads.
            if (!separation(places, bead[0], bead[1], arm[0], failure) ||
                !separation(places, bead[2], bead[1], arm[1], failure) ||
                !separation(places, bead[3], bead[1], arm[2], failure)) {
                return false;
            }
            const OutOfPlane height = height_above(arm[0], arm[1], arm[2]);
            const Value value = law(height.value);
            return worker.add<4>(
                index(Kind::inversion), {bead[0], bead[2], bead[3], bead[1]}, value.energy,
                {-value.slope * height.by_vector, -value.slope * height.by_first, -value.slope * height.by_second},
                arm);
        } else {
            for (std::size_t k = 0; k < 3; ++k) {
                if (!separation(places, bead[k + 1], bead[0], arm[k], failure)) {
                    return false;
                }
            }
            double energy = 0.0;
            std::array<Vector3, 3> force{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t first = (k + 1) % 3;
                const std::size_t second = (k + 2) % 3;
                const OutOfPlane angle = angle_above(arm[k], arm[first], arm[second]);
                const Value value = law(std::abs(angle.value));
                const double slope = angle.value < 0.0   ? -value.slope / 3.0
                                     : angle.value > 0.0 ? value.slope / 3.0
                                                         : 0.0;
                energy += value.energy / 3.0;
                force[k] -= slope * angle.by_vector;
                force[first] -= slope * angle.by_first;
                force[second] -= slope * angle.by_second;
            }
            return worker.add<4>(index(Kind::inversion), {bead[1], bead[2], bead[3], bead[0]}, energy, force, arm);
        }
    }

    std::vector<Law> laws_;
    std::vector<Term> terms_;
    std::vector<std::size_t> start_;
};

}  // namespace

std::unique_ptr<TermList> make_term_list(Kind kind, std::string_view key) {
    std::unique_ptr<TermList> list;
    visit(kind, key, [&]<class Law>() { list = std::make_unique<TermListOf<Law>>(); });
    return list;
}

}  // namespace dlpoly::bonded
