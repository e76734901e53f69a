// Turns the core's RunFailure into pydlpoly.errors.RunError.
#include <pybind11/pybind11.h>

#include "bind/bind.hpp"
#include "core/failure.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

void bind_errors(py::module_& /*m*/) {
    py::register_exception_translator([](std::exception_ptr pointer) {
        try {
            if (pointer) {
                std::rethrow_exception(pointer);
            }
        } catch (const RunFailure& failure) {
            py::set_error(py::module_::import("pydlpoly.errors").attr("RunError"), failure.what());
        }
    });
}

}  // namespace dlpoly::bind
