// The parts of the Python module; module.cpp calls each once.
#pragma once

#include <pybind11/pybind11.h>

void bind_pair(pybind11::module_& module);
