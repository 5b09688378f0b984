#include "amb_rotor/ros/node_programs.hpp"

#include "amb_rotor/ros/analysis_node.hpp"
#include "amb_rotor/ros/node_setup.hpp"
#include "amb_rotor/ros/orbit_markers.hpp"
#include "amb_rotor/ros/partner_nodes.hpp"
#include "amb_rotor/ros/rotor_plant.hpp"
#include "amb_rotor/ros/validator.hpp"

namespace amb_rotor {

int runRotorPlant(int argc, char** argv) { return runNode<RotorPlant>(argc, argv, "rotor_plant"); }
int runAmbController(int argc, char** argv) { return runNode<AmbController>(argc, argv, "amb_controller"); }
int runAuxiliaryBearing(int argc, char** argv) {
  return runNode<AuxiliaryBearing>(argc, argv, "auxiliary_bearing");
}
int runInjector(int argc, char** argv) { return runNode<Injector>(argc, argv, "injector"); }
int runAnalysisNode(int argc, char** argv) { return runNode<AnalysisNode>(argc, argv, "analysis"); }
int runOrbitMarkers(int argc, char** argv) { return runNode<OrbitMarkers>(argc, argv, "orbit_markers"); }
int runValidator(int argc, char** argv) { return runNode<Validator>(argc, argv, "validator"); }

}  // namespace amb_rotor
