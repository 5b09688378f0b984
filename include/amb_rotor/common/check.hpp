#pragma once
// AMB_ROTOR_CHECK: an invariant of the program that is checked in all builds.
#include "amb_rotor/common/error.hpp"
