// amb_rotor._core: the core for Python. One bind function a file.
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
void bindMakeDataset(py::module_& m);
void bindMotion(py::module_& m);
void bindReduce(py::module_& m);
}  // namespace amb_rotor

namespace {

/// The core's InputError as amb_rotor.errors.InputError, fault by fault.
void raiseInputError(const amb_rotor::InputError& error) {
  py::list faults;
  for (const auto& fault : error.faults()) {
    const std::string text = fault.text();  // may hold bytes of a file that is none of ours
    faults.append(py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "replace")));
  }
  const py::object type = py::module_::import("amb_rotor.errors").attr("InputError");
  PyErr_SetObject(type.ptr(), type(faults).ptr());
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const amb_rotor::InputError& error) {
      raiseInputError(error);
    }
  });
  amb_rotor::bindModel(m);
  amb_rotor::bindSimulate(m);
  amb_rotor::bindAnalysis(m);
  amb_rotor::bindModes(m);
  amb_rotor::bindValidation(m);
  amb_rotor::bindSweep(m);
  amb_rotor::bindMotion(m);
  amb_rotor::bindMakeDataset(m);
  amb_rotor::bindReduce(m);
}
