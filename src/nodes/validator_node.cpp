#include "amb_rotor/ros/node_setup.hpp"
#include "amb_rotor/ros/validator.hpp"

int main(int argc, char** argv) { return amb_rotor::runNode<amb_rotor::Validator>(argc, argv, "validator"); }
