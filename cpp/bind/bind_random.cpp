// The random numbers of the core, for tests of their quality and for analysis.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bind/bind.hpp"
#include "core/random.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

void bind_random(py::module_& m) {
    m.def(
        "pair_noise",
        [](std::uint64_t seed, std::uint64_t step, const py::array_t<std::uint32_t>& i,
           const py::array_t<std::uint32_t>& j, std::uint8_t image) {
            return py::vectorize([seed, step, image](std::uint32_t a, std::uint32_t b) {
                return dlpoly::pair_noise(seed, step, a, b, image);
            })(i, j);
        },
        py::arg("seed"), py::arg("step"), py::arg("i"), py::arg("j"), py::arg("image") = 0,
        "Standard normal noise of the pairs (i, j) of bead ids (from 0) in a step; precision reference.");
    m.def(
        "word_noise",
        [](std::uint64_t seed, std::uint64_t step, const py::array_t<std::uint32_t>& i,
           const py::array_t<std::uint32_t>& j, std::uint32_t image) {
            const auto key = bead_word_key(seed, step);
            return py::vectorize([key, image](std::uint32_t a, std::uint32_t b) {
                return word_to_noise * mix_words(bead_word(a, key.data()), bead_word(b, key.data()), image);
            })(i, j);
        },
        py::arg("seed"), py::arg("step"), py::arg("i"), py::arg("j"), py::arg("image") = 0,
        "Uniform noise of unit variance of the pairs (i, j) in a step, mixed from the beads' random words.");
    m.def("philox", &dlpoly::philox, py::arg("counter"), py::arg("key"),
          "The four words of Philox4x32-10 for one counter and key.");
}

}  // namespace dlpoly::bind
