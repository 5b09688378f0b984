#pragma once
// The node classes as programs, for each main(): whole classes with all of ROS in a file of one line cost
// seconds.
namespace amb_rotor {

int runRotorPlant(int argc, char** argv);
int runAmbController(int argc, char** argv);
int runAuxiliaryBearing(int argc, char** argv);
int runInjector(int argc, char** argv);
int runAnalysisNode(int argc, char** argv);
int runOrbitMarkers(int argc, char** argv);
int runValidator(int argc, char** argv);

}  // namespace amb_rotor
