#pragma once
// Walking over the numeric fields of a parameter struct by name: the one list that the file reader, the
// writer, `--set path=value`, the uncertainties and the lane gather share.
//
// A struct Parameters<S> offers  template <class P, class F> static void visit(P& p, F&& f)  that calls
// f("dotted.path", field) for each of its Scalar fields, always in the same order.
#include <cstddef>
#include <vector>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

/// Fills `target` (fields of type S) from one struct of doubles for each lane; a last machine is
/// repeated in the lanes that are left over.
template <template <class> class Parameters, class S>
void gatherFields(const std::vector<const Parameters<double>*>& machines, Parameters<S>& target) {
  AMB_ROTOR_CHECK(!machines.empty(), "no machine to gather");
  std::vector<std::vector<double>> columns;
  for (const auto* machine : machines) {
    std::vector<double> column;
    Parameters<double>::visit(*machine, [&](const char*, const double& value) { column.push_back(value); });
    columns.push_back(std::move(column));
  }
  std::size_t index = 0;
  Parameters<S>::visit(target, [&](const char*, S& field) {
    for (std::size_t lane = 0; lane < ScalarTraits<S>::lanes; ++lane) {
      const auto& column = columns[lane < columns.size() ? lane : columns.size() - 1];
      setLane(field, lane, column.at(index));
    }
    ++index;
  });
}

}  // namespace amb_rotor
