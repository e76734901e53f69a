// Fixed distances (see constraints.hpp).
#include "constraints/constraints.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "bonded/geometry.hpp"
#include "core/failure.hpp"
#include "core/random.hpp"

namespace dlpoly {

namespace {

// A direction that turned farther than this (its cosine) within one move holds no length any more.
constexpr double least_cosine = 0.1;

// For every bead the smallest bead that constraints connect it with.
std::vector<std::uint32_t> clusters_of(const std::vector<Constraint>& constraints, std::size_t beads) {
    std::vector<std::uint32_t> root(beads);
    std::iota(root.begin(), root.end(), 0U);
    const auto find = [&root](std::uint32_t bead) {
        while (root[bead] != bead) {
            root[bead] = root[root[bead]];
            bead = root[bead];
        }
        return bead;
    };
    for (const Constraint& c : constraints) {
        const auto [low, high] = std::minmax({find(c.i), find(c.j)});
        root[high] = low;
    }
    for (std::size_t bead = 0; bead < beads; ++bead) {
        root[bead] = find(static_cast<std::uint32_t>(bead));
    }
    return root;
}

}  // namespace

Constraints::Constraints(std::vector<Constraint> constraints, const Particles& particles, double tolerance,
                         std::int64_t most_iterations)
    : constraints_(std::move(constraints)), tolerance_(tolerance), most_iterations_(most_iterations) {
    const auto beads = static_cast<std::size_t>(particles.count());
    if (!(tolerance > 0.0) || most_iterations < 1) {
        throw std::invalid_argument("constraints need a tolerance above 0 and at least one iteration");
    }
    for (const Constraint& c : constraints_) {
        if (c.i >= beads || c.j >= beads || c.i == c.j || !(c.length > tolerance && std::isfinite(c.length))) {
            throw std::invalid_argument("a constraint needs two beads and a length above the tolerance");
        }
    }
    std::erase_if(constraints_,
                  [&](const Constraint& c) { return particles.frozen[c.i] != 0 && particles.frozen[c.j] != 0; });
    const std::vector<std::uint32_t> cluster = clusters_of(constraints_, beads);
    std::stable_sort(constraints_.begin(), constraints_.end(),
                     [&](const Constraint& a, const Constraint& b) { return cluster[a.i] < cluster[b.i]; });
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
        if (k == 0 || cluster[constraints_[k].i] != cluster[constraints_[k - 1].i]) {
            start_.push_back(k);
        }
    }
    start_.push_back(constraints_.size());
    inverse_mass_.resize(beads);
    for (std::size_t i = 0; i < beads; ++i) {
        inverse_mass_[i] = particles.inverse_mass(static_cast<Eigen::Index>(i));
    }
    for (const Constraint& c : constraints_) {
        for (const std::uint32_t bead : {c.i, c.j}) {
            if (particles.frozen[bead] == 0) {
                beads_.push_back(bead);
            }
        }
    }
    std::sort(beads_.begin(), beads_.end());
    beads_.erase(std::unique(beads_.begin(), beads_.end()), beads_.end());
}

void Constraints::find_arms(const Box& box, const Particles& particles, std::vector<Vector3>& arms) const {
    const bonded::MinimumImage image(box);
    arms.resize(constraints_.size());
    const auto count = static_cast<std::int64_t>(constraints_.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t n = 0; n < count; ++n) {
        const auto k = static_cast<std::size_t>(n);
        arms[k] = (particles.position.row(constraints_[k].i) - particles.position.row(constraints_[k].j)).transpose();
        // Lengths are shorter than half the cell: the scene has seen to it.
        static_cast<void>(image.shorten(arms[k]));
    }
}

bool Constraints::keep_lengths(Range cluster, Array3N& velocity, double time) const {
    for (std::int64_t iteration = 0; iteration < most_iterations_; ++iteration) {
        bool kept = true;
        for (std::size_t k = cluster.first; k < cluster.last; ++k) {
            const auto [i, j, length] = constraints_[k];
            const Vector3 arm = arms_[k] + time * (velocity.row(i) - velocity.row(j)).transpose();
            const double missing = length * length - arm.squaredNorm();
            if (std::abs(missing) <= (2.0 * length - tolerance_) * tolerance_) {
                continue;
            }
            kept = false;
            const double along = arm.dot(arms_[k]);
            if (!(along > least_cosine * length * length)) {
                return false;
            }
            const double push = missing / (2.0 * time * (inverse_mass_[i] + inverse_mass_[j]) * along);
            velocity.row(i) += push * inverse_mass_[i] * arms_[k].transpose();
            velocity.row(j) -= push * inverse_mass_[j] * arms_[k].transpose();
        }
        if (kept) {
            return true;
        }
    }
    return false;
}

bool Constraints::keep_directions(Range cluster, Array3N& velocity, double timestep) const {
    for (std::int64_t iteration = 0; iteration < most_iterations_; ++iteration) {
        bool kept = true;
        for (std::size_t k = cluster.first; k < cluster.last; ++k) {
            const auto [i, j, length] = constraints_[k];
            const double along = (velocity.row(i) - velocity.row(j)).dot(arms_[k].transpose());
            if (std::abs(along) <= length * tolerance_ / timestep) {
                continue;
            }
            kept = false;
            const double push = -along / ((inverse_mass_[i] + inverse_mass_[j]) * arms_[k].squaredNorm());
            velocity.row(i) += push * inverse_mass_[i] * arms_[k].transpose();
            velocity.row(j) -= push * inverse_mass_[j] * arms_[k].transpose();
        }
        if (kept) {
            return true;
        }
    }
    return false;
}

// Calls solve(cluster) for all clusters; of those where it fails the first is reported.
template <class Solve>
void Constraints::solve_all(const Solve& solve, const Array3N& velocity, double time, const char* what,
                            std::uint64_t step) const {
    const auto clusters = static_cast<std::int64_t>(start_.size()) - 1;
    std::atomic<std::int64_t> failed{-1};
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t n = 0; n < clusters; ++n) {
        const auto c = static_cast<std::size_t>(n);
        if (!solve(Range{start_[c], start_[c + 1]})) {
            std::int64_t first = failed;
            while ((first < 0 || n < first) && !failed.compare_exchange_weak(first, n)) {
            }
        }
    }
    if (failed >= 0) {
        const auto c = static_cast<std::size_t>(failed);
        fail({start_[c], start_[c + 1]}, velocity, time, what, step);
    }
}

void Constraints::before_move(const Box& box, const Particles& particles, Array3N& velocity, double time,
                              std::uint64_t step) {
    find_arms(box, particles, arms_);
    solve_all([&](Range cluster) { return keep_lengths(cluster, velocity, time); }, velocity, time,
              "positions (SHAKE) are not found", step);
}

void Constraints::before_drift(const Box& box, Particles& particles, double time, std::uint64_t step) {
    before_move(box, particles, particles.velocity, time, step);
}

void Constraints::after_kick(const Box& box, Particles& particles, double timestep, std::uint64_t step) {
    find_arms(box, particles, arms_);
    solve_all([&](Range cluster) { return keep_directions(cluster, particles.velocity, timestep); }, particles.velocity,
              0.0, "velocities (RATTLE) are not found", step);
}

void Constraints::release(const Box& box, Particles& particles, const MaxwellDraw& draw_from, std::uint32_t part,
                          double timestep) {
    if (!(draw_from.thermal_energy > 0.0)) {
        return;
    }
    drawn_.resize(particles.count(), 3);  // rows of other beads are not looked at
    const auto count = static_cast<std::int64_t>(beads_.size());
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t n = 0; n < count; ++n) {
        const std::uint32_t bead = beads_[static_cast<std::size_t>(n)];
        const auto number = [&](std::uint32_t k) {
            return draw(draw_from.seed, Stream::constraints, draw_from.step, bead, 2 * part + k);
        };
        const auto xy = gaussian_pair(number(0));
        const double width = std::sqrt(draw_from.thermal_energy * inverse_mass_[bead]);
        drawn_.row(bead) = width * Vector3(xy[0], xy[1], gaussian(number(1))).transpose();
    }
    for (const Constraint& c : constraints_) {
        for (const std::uint32_t bead : {c.i, c.j}) {
            if (particles.frozen[bead] != 0) {
                drawn_.row(bead).setZero();
            }
        }
    }
    kept_ = drawn_;
    find_arms(box, particles, arms_);
    solve_all([&](Range cluster) { return keep_directions(cluster, kept_, timestep); }, kept_, 0.0,
              "velocities (RATTLE) are not found", draw_from.step);
    for (const std::uint32_t bead : beads_) {
        particles.velocity.row(bead) += drawn_.row(bead) - kept_.row(bead);
    }
}

void Constraints::settle(const Box& box, Particles& particles, std::uint64_t step) {
    Array3N moves = Array3N::Zero(particles.count(), 3);
    before_move(box, particles, moves, 1.0, step);
    for (Eigen::Index i = 0; i < particles.count(); ++i) {
        if (moves.row(i).isZero(0.0)) {
            continue;
        }
        Vector3 position = (particles.position.row(i) + moves.row(i)).transpose();
        box.wrap(position, particles.image.row(i).data());
        particles.position.row(i) = position.transpose();
    }
}

void Constraints::fail(Range cluster, const Array3N& velocity, double time, const char* what,
                       std::uint64_t step) const {
    std::size_t worst = cluster.first;
    double found = 0.0;
    double largest = -1.0;
    bool finite = true;
    for (std::size_t k = cluster.first; k < cluster.last && finite; ++k) {
        const auto [i, j, length] = constraints_[k];
        const Vector3 apart = (velocity.row(i) - velocity.row(j)).transpose();
        const double reached = (arms_[k] + time * apart).norm();
        const double wrong = time > 0.0 ? std::abs(reached - length) : std::abs(apart.dot(arms_[k])) / length;
        finite = std::isfinite(wrong);
        if (!finite || wrong > largest) {
            worst = k;
            largest = wrong;
            found = reached;
        }
    }
    const Constraint& c = constraints_[worst];
    std::ostringstream text;
    text.precision(6);
    text << "step " << step << ": the constraint of beads " << std::min(c.i, c.j) + 1 << " and "
         << std::max(c.i, c.j) + 1;
    if (!finite) {
        text << " has a length or velocity that is not a number";
    } else {
        text << " is not met: " << what << " in " << most_iterations_ << " iterations (shake_max_iter) to "
             << tolerance_ << " (shake_tolerance)";
        if (time > 0.0) {
            text << "; its length is " << found << " instead of " << c.length;
        }
    }
    text << "; the timestep is too long for the forces or velocities, or the lengths contradict each other";
    throw RunFailure(text.str());
}

// Forces λ_k r_k on bead i of constraint k and −λ_k r_k on bead j, such that r_k · (a_i − a_j) + |v_i − v_j|² = 0.
void Constraints::multipliers(Range cluster, const Particles& particles, const std::vector<Vector3>& arms,
                              std::vector<double>& found) const {
    const auto count = static_cast<Eigen::Index>(cluster.last - cluster.first);
    Eigen::MatrixXd matrix(count, count);
    Eigen::VectorXd right(count);
    for (Eigen::Index a = 0; a < count; ++a) {
        const std::size_t k = cluster.first + static_cast<std::size_t>(a);
        const auto [i, j, length] = constraints_[k];
        const Vector3 apart = (particles.velocity.row(i) - particles.velocity.row(j)).transpose();
        const Vector3 pull =
            (inverse_mass_[i] * particles.force.row(i) - inverse_mass_[j] * particles.force.row(j)).transpose();
        right[a] = -apart.squaredNorm() - arms[k].dot(pull);
        for (Eigen::Index b = 0; b <= a; ++b) {
            const std::size_t l = cluster.first + static_cast<std::size_t>(b);
            const Constraint& other = constraints_[l];
            const auto sign = [&](std::uint32_t bead) {
                return (other.i == bead ? 1.0 : 0.0) - (other.j == bead ? 1.0 : 0.0);
            };
            const double shared = inverse_mass_[i] * sign(i) - inverse_mass_[j] * sign(j);
            matrix(a, b) = matrix(b, a) = shared * arms[k].dot(arms[l]);
        }
    }
    const Eigen::VectorXd solved = matrix.ldlt().solve(right);
    std::copy(solved.begin(), solved.end(), found.begin() + static_cast<std::ptrdiff_t>(cluster.first));
}

Matrix3 Constraints::virial(const Box& box, const Particles& particles) const {
    std::vector<Vector3> arms;
    find_arms(box, particles, arms);
    std::vector<double> found(constraints_.size());
    const auto clusters = static_cast<std::int64_t>(start_.size()) - 1;
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::int64_t n = 0; n < clusters; ++n) {
        const auto c = static_cast<std::size_t>(n);
        multipliers({start_[c], start_[c + 1]}, particles, arms, found);
    }
    Matrix3 sum = Matrix3::Zero();
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
        sum += found[k] * arms[k] * arms[k].transpose();
    }
    return sum;
}

double Constraints::deviation(const Box& box, const Particles& particles) const {
    std::vector<Vector3> arms;
    find_arms(box, particles, arms);
    double largest = 0.0;
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
        largest = std::max(largest, std::abs(arms[k].norm() - constraints_[k].length));
    }
    return largest;
}

}  // namespace dlpoly
