#pragma once
// A model: a rig as believed, a choice of rotor and bearing model, and a list of effects.
// File format amb-model/1; doc/formats.md.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "amb_rotor/model/control_options.hpp"
#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/rig.hpp"

namespace amb_rotor {

class FaultList;  // model/yaml_document.hpp

/// One entry of `effects:`; values in the order of the effect's schema.
struct EffectSetting {
  std::string id;
  std::vector<double> values;
};

/// Modes of a flexible rotor, per plane (x or y), in a basis where mass, stiffness and damping are
/// diagonal: m_k q_k'' + d_k q_k' + k_k q_k +- Omega sum_l g_kl q_l' = sum_planes shape_k(z) F(z).
/// Filled from a geometry by the rotor layer; a model of rigid_mass or rigid_beam has none.
struct FlexibleModes {
  std::vector<double> mass, stiffness, damping;  ///< n each
  std::vector<double> gyroscopic;                ///< n*n, symmetric
  /// Within an element a shape is a cubic of z (rotor/shaft_element.hpp): four rows, its ends counted, say all of it.
  static constexpr std::size_t rows_an_element = 3;
  std::vector<double> z_m;                       ///< axial positions at which shapes are tabulated: nodes, thirds between
  std::vector<double> shape;                     ///< z_m.size() * n, row by row
};

/// What a run keeps of a flexible rotor.
struct RotorReduction {
  enum class Method {
    by_frequency,  ///< the free modes up to a frequency far above what the bearings reach
    modal,         ///< the lowest free modes
    craig_bampton,  ///< the displacements at bearings and sensors, and the lowest modes with these held
    balanced        ///< what bearings and sensors drive and see most
  };
  Method method = Method::by_frequency;
  int modes = 0;  ///< modal, balanced: the two rigid ones counted; craig_bampton: those held
};

/// Friction where the surfaces stop sliding.
enum class FrictionLaw {
  regularised,  ///< mu N tanh(v/v0): creeps instead of sticking; everywhere
  set_valued    ///< Coulomb with stick, by located events
};

struct Model {
  std::string name;
  RotorModel rotor_model = RotorModel::rigid_beam;
  AmbModel amb_model = AmbModel::linear;
  FrictionLaw friction_law = FrictionLaw::regularised;
  Rig<double> rig;
  ControlOptions control;           ///< beyond the PID of the rig block
  SignalChain signal_chain;         ///< empty: exact samples and commands
  std::optional<CoilCircuit> coil;  ///< not there: a first-order lag without a voltage limit
  std::map<std::string, double> uncertainty;  ///< by dotted path; relative but for offsets and phases
  std::vector<EffectSetting> effects;
  FlexibleModes flexible;       ///< for RotorModel::flexible
  RotorReduction reduction;     ///< for RotorModel::flexible
  std::string rotor_geometry;   ///< path of the geometry file as given; empty without
  std::string folder;           ///< of the file it was read from: the geometry's path is relative to it
  std::shared_ptr<const FaultList> source;  ///< the file it was read from, and the lines of its values; null: made otherwise
  std::string revision;         ///< YAML text of the optional `revision:` block (who changed what, and why)
};

}  // namespace amb_rotor
