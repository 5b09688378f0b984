#include "amb_rotor/ros/analysis_node.hpp"

#include "amb_rotor/ros/node_setup.hpp"

int main(int argc, char** argv) {
  return amb_rotor::runNode<amb_rotor::AnalysisNode>(argc, argv, "analysis");
}
