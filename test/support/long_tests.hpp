#pragma once
// Tests of minutes are skipped where nobody asked for them: `amb test --long`.
#include <gtest/gtest.h>

#include <cstdlib>

#define AMB_ROTOR_SKIP_UNLESS_LONG()                                                          \
  do {                                                                                        \
    const char* const asked = std::getenv("AMB_ROTOR_LONG");                                  \
    if (asked == nullptr || *asked == '\0') GTEST_SKIP() << "takes minutes: amb test --long"; \
  } while (false)
