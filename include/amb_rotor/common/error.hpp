#pragma once
// Typed errors. Three audiences, three kinds:
//  - InputError: a person's description (file, command line) is wrong. Lists every fault at once.
//  - numerical failures are results (see integration/), never exceptions.
//  - AMB_ROTOR_CHECK: an internal invariant, checked in all builds.
#include <stdexcept>
#include <string>
#include <vector>

namespace amb_rotor {

/// One thing that is wrong in a description that a person wrote.
struct Fault {
  std::string file;   ///< path as given by the caller; empty when there is no file
  int line = 0;       ///< 1-based; 0: unknown
  std::string key;    ///< dotted path, e.g. rig.rotor.mass_kg
  std::string value;  ///< as written; may be empty
  std::string rule;   ///< the rule that is broken, with its unit

  std::string text() const;
};

/// Bad input: carries all faults that were found.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Fault> faults);
  const std::vector<Fault>& faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

/// An internal invariant was broken: a defect of this program.
class InvariantError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void invariantFailed(const char* expression, const char* file, int line,
                                  const std::string& detail);

}  // namespace amb_rotor

#define AMB_ROTOR_CHECK(expression, detail)                                          \
  do {                                                                               \
    if (!(expression)) ::amb_rotor::invariantFailed(#expression, __FILE__, __LINE__, detail); \
  } while (false)
