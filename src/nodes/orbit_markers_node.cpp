#include "amb_rotor/ros/node_programs.hpp"

int main(int argc, char** argv) { return amb_rotor::runOrbitMarkers(argc, argv); }
