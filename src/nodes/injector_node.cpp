#include "amb_rotor/ros/node_setup.hpp"
#include "amb_rotor/ros/partner_nodes.hpp"

int main(int argc, char** argv) { return amb_rotor::runNode<amb_rotor::Injector>(argc, argv, "injector"); }
