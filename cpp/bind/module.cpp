// Table of contents of the compiled core.
#include <pybind11/pybind11.h>

#include "bind/bind.hpp"

PYBIND11_MODULE(_core, m) {
    m.doc() = "Compiled core of pydlpoly: pair laws, mixing, forces, integration. Use it through the Python package.";
    m.attr("__version__") = PYDLPOLY_VERSION;
    dlpoly::bind::bind_errors(m);
    dlpoly::bind::bind_pair(m);
    dlpoly::bind::bind_bonded(m);
    dlpoly::bind::bind_charge(m);
    dlpoly::bind::bind_random(m);
    dlpoly::bind::bind_settings(m);
    dlpoly::bind::bind_system(m);
    dlpoly::bind::bind_heat(m);
    dlpoly::bind::bind_transport(m);
}
