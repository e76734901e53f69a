// The parts of the compiled module; module.cpp calls each once.
#pragma once

#include <pybind11/pybind11.h>

namespace dlpoly::bind {

void bind_bonded(pybind11::module_& m);     // bonded laws and terms
void bind_charge(pybind11::module_& m);     // electrostatics
void bind_errors(pybind11::module_& m);     // exceptions of the core
void bind_heat(pybind11::module_& m);       // heat that beads carry
void bind_pair(pybind11::module_& m);       // pair laws, their tails and their mixing
void bind_random(pybind11::module_& m);     // random numbers
void bind_settings(pybind11::module_& m);   // pair tables and step settings
void bind_system(pybind11::module_& m);     // the simulation
void bind_transport(pybind11::module_& m);  // dissolved species

}  // namespace dlpoly::bind
