#include "amb_rotor/ros/recorder.hpp"

int main(int argc, char** argv) { return amb_rotor::runRecorder(argc, argv); }
