// What a system is made of: the pair table, and how a step is taken.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "bind/bind.hpp"
#include "bind/pair_table_builder.hpp"
#include "integrate/step_settings.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

void bind_settings(py::module_& m) {
    py::class_<PairTableBuilder>(m, "PairTable", "What acts between every two species; makes one System.")
        .def(py::init<std::int32_t>(), py::arg("species"))
        .def("set_law", &PairTableBuilder::set_law, py::arg("a"), py::arg("b"), py::arg("key"), py::arg("parameters"),
             py::arg("cutoff"), py::arg("force_shift") = false)
        .def("set_table", &PairTableBuilder::set_table, py::arg("a"), py::arg("b"), py::arg("energy"),
             py::arg("virial"), py::arg("spacing"), py::arg("cutoff"), py::arg("force_shift") = false)
        .def("set_drag", &PairTableBuilder::set_drag, py::arg("a"), py::arg("b"), py::arg("drag"), py::arg("noise"),
             py::arg("cutoff"));

    py::enum_<Precision>(m, "Precision", "How pairs are computed; see cpp/integrate/step_settings.hpp.")
        .value("reference", Precision::reference)
        .value("double_precision", Precision::double_precision)
        .value("mixed", Precision::mixed);

    py::enum_<Order>(m, "Order", "The integrators; see cpp/integrate.")
        .value("velocity_verlet", Order::velocity_verlet)
        .value("dpdvv", Order::dpdvv)
        .value("scvv", Order::scvv)
        .value("zeroth", Order::zeroth)
        .value("first", Order::first)
        .value("second", Order::second)
        .value("peters", Order::peters)
        .value("peters_first", Order::peters_first)
        .value("lowe_andersen", Order::lowe_andersen)
        .value("stoyanov_groot", Order::stoyanov_groot)
        .value("ou", Order::ou)
        .value("ou_middle", Order::ou_middle)
        .value("middle", Order::middle)
        .value("nose_hoover_langevin", Order::nose_hoover_langevin)
        .value("langevin", Order::langevin)
        .value("berendsen", Order::berendsen)
        .value("hoover", Order::hoover);

    py::class_<TemperatureSchedule>(m, "TemperatureSchedule", "k_B T against time; see step_settings.hpp.")
        .def(py::init<>())
        .def_readwrite("times", &TemperatureSchedule::times)
        .def_readwrite("energies", &TemperatureSchedule::energies)
        .def_readwrite("amplitude", &TemperatureSchedule::amplitude)
        .def_readwrite("period", &TemperatureSchedule::period)
        .def_readwrite("phase", &TemperatureSchedule::phase)
        .def("at", &TemperatureSchedule::at, py::arg("time"), py::arg("thermal_energy"));

    py::enum_<CellMotion>(m, "CellMotion", "Which edges of the cell follow the pressure; see step_settings.hpp.")
        .value("fixed", CellMotion::fixed)
        .value("isotropic", CellMotion::isotropic)
        .value("height", CellMotion::height)
        .value("square", CellMotion::square)
        .value("edges", CellMotion::edges);

    py::class_<Barostat>(m, "Barostat", "A Langevin piston; see cpp/integrate/piston.hpp.")
        .def(py::init<>())
        .def_readwrite("motion", &Barostat::motion)
        .def_readwrite("pressure", &Barostat::pressure)
        .def_readwrite("tension", &Barostat::tension)
        .def_readwrite("relaxation", &Barostat::relaxation)
        .def_readwrite("friction", &Barostat::friction)
        .def_readwrite("tail", &Barostat::tail);

    py::class_<StepSettings>(m, "StepSettings", "How a step is taken; see cpp/integrate/step_settings.hpp.")
        .def(py::init<>())
        .def_readwrite("precision", &StepSettings::precision)
        .def_readwrite("timestep", &StepSettings::timestep)
        .def_readwrite("thermal_energy", &StepSettings::thermal_energy)
        .def_readwrite("weight_exponent", &StepSettings::weight_exponent)
        .def_readwrite("prediction", &StepSettings::prediction)
        .def_readwrite("half_step_kinetic", &StepSettings::half_step_kinetic)
        .def_readwrite("order", &StepSettings::order)
        .def_readwrite("schedule", &StepSettings::schedule)
        .def_readwrite("transverse_drag", &StepSettings::transverse_drag)
        .def_readwrite("collision_rate", &StepSettings::collision_rate)
        .def_readwrite("thermostat_coupling", &StepSettings::thermostat_coupling)
        .def_readwrite("thermostat_mass", &StepSettings::thermostat_mass)
        .def_readwrite("thermostat_friction", &StepSettings::thermostat_friction)
        .def_readwrite("relaxation", &StepSettings::relaxation)
        .def_readwrite("tolerance", &StepSettings::tolerance)
        .def_readwrite("passes", &StepSettings::passes)
        .def_readwrite("thermostat_every", &StepSettings::thermostat_every)
        .def_readwrite("drag", &StepSettings::drag)
        .def_readwrite("remove_drift", &StepSettings::remove_drift)
        .def_readwrite("seed", &StepSettings::seed)
        .def_readwrite("degrees_of_freedom", &StepSettings::degrees_of_freedom)
        .def_readwrite("force_cap", &StepSettings::force_cap)
        .def_readwrite("equilibration_steps", &StepSettings::equilibration_steps)
        .def_readwrite("rescale_every", &StepSettings::rescale_every)
        .def_readwrite("regauss_every", &StepSettings::regauss_every)
        .def_readwrite("barostat", &StepSettings::barostat)
        .def_readwrite("shear_rate", &StepSettings::shear_rate);
}

}  // namespace dlpoly::bind
