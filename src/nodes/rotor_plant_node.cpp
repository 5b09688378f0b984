#include "amb_rotor/ros/node_setup.hpp"
#include "amb_rotor/ros/rotor_plant.hpp"

int main(int argc, char** argv) {
  return amb_rotor::runNode<amb_rotor::RotorPlant>(argc, argv, "rotor_plant");
}
