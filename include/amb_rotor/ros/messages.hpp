#pragma once
// All messages of the package. The message amb_rotor/Fault is called FaultMessage here: the core has a Fault
// of its own (common/error.hpp) in the same namespace. Include no generated header but through this one.
#define Fault FaultMessage
#include "amb_rotor/ContactForces.h"
#include "amb_rotor/ControlCommand.h"
#include "amb_rotor/Fault.h"
#include "amb_rotor/FullSpectrum.h"
#include "amb_rotor/Injection.h"
#include "amb_rotor/ModelInfo.h"
#include "amb_rotor/ModelResidual.h"
#include "amb_rotor/OrbitAnalysis.h"
#include "amb_rotor/PlantStatus.h"
#include "amb_rotor/RotorState.h"
#include "amb_rotor/SectionPoint.h"
#include "amb_rotor/Tacho.h"
#undef Fault
