#pragma once
// A table of numbers: comma separated, one header line, plain (.csv) or compressed (.csv.gz).
//
// Rules: every cell is a finite decimal number; every line has as many cells as the header; lines end with
// LF or CRLF; no empty line but at the end; a compressed file must be whole. Faults carry the line. What is another format as a
// whole (semicolons or tabs, decimal commas, quotation marks, UTF-16, no header) is one fault that names it.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {

struct NumericTable {
  std::vector<std::string> columns;         ///< names as in the header
  std::vector<std::vector<double>> values;  ///< one vector a column
  std::size_t rows() const { return values.empty() ? 0 : values.front().size(); }
  /// Position of a column; -1 where there is none.
  int indexOf(const std::string& column) const;
  /// Line of the file in which row r stands, 1-based.
  static int lineOf(std::size_t row) { return static_cast<int>(row) + 2; }
};

/// No file that is unpacked to more than this is read.
constexpr std::size_t max_table_bytes = std::size_t{1} << 30;

/// After so many bad cells or lines the rest is only counted.
constexpr std::size_t max_cell_faults = 20;

/// Reads `path` by its ending. All faults go to `faults`, whose file must be `path`; where there is one the
/// table is not to be used.
NumericTable readTable(const std::string& path, FaultList& faults);

/// The same from the text of a table.
NumericTable parseTable(const std::string& text, FaultList& faults);

/// How a text as a whole is no table of ours, and what to do, by its header and first row; empty: nothing of the kind.
std::string otherTableFormat(std::string_view text);

/// The contents of a gzip file; a damaged or cut one is a fault.
std::string readCompressed(const std::string& path, FaultList& faults);

/// A name with a unit behind its last underscore: "ax_um" is quantity "ax", unit "um".
struct NameWithUnit {
  std::string quantity;
  std::string unit;
};
NameWithUnit splitUnit(const std::string& name);

}  // namespace amb_rotor
