// amb_rotor._core: blind data sets of our own.
#include "amb_rotor/validation/make_dataset.hpp"

#include "amb_rotor/effects/catalogue.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {

void bindMakeDataset(py::module_& m) {
  m.def("hidden_laws", &hiddenLaws, "Laws of no catalogue that a made data set can hide.");
  m.def(
      "make_dataset",
      [](std::uint64_t seed, const std::vector<std::string>& effects, double strength, bool contact,
         const std::string& out, bool set_valued_friction) {
        MadeDataset made;
        {
          const py::gil_scoped_release release;
          made = makeDataset({seed, effects, strength, contact, out, {},
                              set_valued_friction ? FrictionLaw::set_valued : FrictionLaw::regularised});
        }
        py::dict d;
        py::list hidden;
        for (const auto& effect : made.truth.effects) {
          const EffectSchema* schema = effectCatalogue().find(effect.id);
          py::dict values;
          for (std::size_t i = 0; i < effect.values.size(); ++i)
            values[py::str(schema->parameters[i].name)] = effect.values[i];
          py::dict one;
          one["effect"] = effect.id;
          one["parameters"] = values;
          hidden.append(one);
        }
        d["effects"] = hidden;
        d["verdict"] = made.verdict;
        d["law"] = made.law;
        d["depends_on"] = made.depends_on;
        d["difference"] = made.difference;
        d["floor"] = made.floor;
        d["mass_kg"] = made.belief.rig.rotor.mass_kg;
        return d;
      },
      py::arg("seed"), py::arg("effects") = std::vector<std::string>(), py::arg("strength") = 0.0,
      py::arg("contact") = false, py::arg("out"), py::arg("set_valued_friction") = false);
}

}  // namespace amb_rotor
