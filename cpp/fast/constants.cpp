// Constants of pairs (see constants.hpp).
#include "fast/constants.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/random.hpp"

namespace dlpoly::fast {

template <class Record>
Constants<Record> make_constants(const Kinds& kinds, const PairTable& table, const Scheme& scheme, const Units& units) {
    using Arithmetic = typename Record::Arithmetic;
    Constants<Record> made;
    const std::size_t count = kinds.list.size();
    const double impulse = scheme.timestep * units.longest / (units.momentum * fixed_range<Record>());
    const double velocity =
        units.momentum * fixed_range<Record>() / units.longest / (count == 1 ? kinds.list.front().mass : 1.0);
    const double noise = word_to_noise / std::sqrt(scheme.timestep);
    for (std::size_t i = 0; i < count; ++i) {
        const Kinds::Kind& a = kinds.list[i];
        made.inverse_mass[i] = static_cast<Arithmetic>(a.frozen ? 0.0 : 1.0 / a.mass);
        made.drift[i] = static_cast<Arithmetic>(a.frozen ? 0.0
                                                         : units.momentum * scheme.timestep / (a.mass * units.longest) *
                                                               std::ldexp(1.0, Record::position_bits));
        made.half_drift[i] = static_cast<Arithmetic>(0.5) * made.drift[i];
        for (std::size_t j = 0; j < count; ++j) {
            const Kinds::Kind& b = kinds.list[j];
            const std::uint32_t term = table.term(a.species, b.species);
            const PairTable::SoftLaw law = table.soft_law(term);
            const PairDrag& drag = table.drags()[term];
            const bool dragged = scheme.has_drag && drag.drag > 0.0;
            const double cutoff = law.cutoff > 0.0 ? law.cutoff : dragged ? drag.cutoff : table.range();
            PairRow<Arithmetic>& row = made.rows[i];
            row.inverse_cutoff[j] = static_cast<Arithmetic>(1.0 / cutoff);
            if (a.frozen && b.frozen) {
                continue;
            }
            row.repulsion[j] = static_cast<Arithmetic>(impulse * law.repulsion);
            row.energy[j] = static_cast<Arithmetic>(0.5 * law.repulsion * law.cutoff);
            row.drag[j] = static_cast<Arithmetic>(dragged ? scheme.every * impulse * drag.drag * velocity : 0.0);
            row.noise[j] =
                static_cast<Arithmetic>(dragged ? std::sqrt(scheme.every) * impulse * drag.noise * noise : 0.0);
        }
    }
    for (std::size_t i = 0; scheme.middle && i < count; ++i) {
        made.motion_rows[i] = made.rows[i];
        for (std::size_t j = 0; j < count; ++j) {
            made.motion_rows[i].repulsion[j] = made.motion_rows[i].energy[j] = 0;
            made.rows[i].drag[j] = made.rows[i].noise[j] = 0;
        }
        made.noise_rows[i] = made.drag_rows[i] = made.motion_rows[i];
        for (std::size_t j = 0; j < count; ++j) {
            made.noise_rows[i].drag[j] = made.drag_rows[i].noise[j] = 0;
        }
    }
    return made;
}

template Constants<MixedRecord> make_constants<MixedRecord>(const Kinds&, const PairTable&, const Scheme&,
                                                            const Units&);
template Constants<DoubleRecord> make_constants<DoubleRecord>(const Kinds&, const PairTable&, const Scheme&,
                                                              const Units&);

}  // namespace dlpoly::fast
