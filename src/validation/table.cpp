#include "amb_rotor/validation/table.hpp"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <string_view>

namespace amb_rotor {
namespace {

bool endsWith(const std::string& text, const std::string& tail) {
  return text.size() >= tail.size() && text.compare(text.size() - tail.size(), tail.size(), tail) == 0;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

std::string_view firstLine(std::string_view text) { return text.substr(0, text.find('\n')); }

bool holds(std::string_view text, char c) { return text.find(c) != std::string_view::npos; }

/// A cell as it can stand in a message.
std::string printable(std::string_view cell) {
  std::string out(cell);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  return out;
}

/// Whether a line holds a number with a comma for its point: 0,25.
bool hasDecimalComma(std::string_view line) {
  const auto digit = [&](std::size_t i) { return i < line.size() && line[i] >= '0' && line[i] <= '9'; };
  for (std::size_t i = 1; i < line.size(); ++i)
    if (line[i] == ',' && digit(i - 1) && digit(i + 1)) return true;
  return false;
}

/// "the cells are parted by semicolons ..." of a header without commas; empty where nothing else parts it.
std::string otherSeparator(std::string_view header, std::string_view row) {
  struct Separator {
    char is;
    const char *name, *in_shell;
  };
  constexpr Separator separators[] = {{';', "semicolons", ";"}, {'\t', "tabs", "\\t"}, {' ', "blanks", " "}};
  for (const Separator& separator : separators) {
    if (!holds(header, separator.is)) continue;
    const bool comma = hasDecimalComma(row);
    return std::string("the cells are parted by ") + separator.name + (comma ? ", and the numbers have decimal commas" : "") +
           "; a table is comma separated, with decimal points: tr " + (separator.is == ' ' ? "-s '" : "'") + (comma ? "," : "") +
           separator.in_shell + "' '" + (comma ? "." : "") + ",' < IN > OUT";
  }
  return "";
}

class TableParser {
 public:
  TableParser(const std::string& text, FaultList& faults) : rest_(text), faults_(faults) {}

  NumericTable parse() {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (rest_.substr(0, byte_order_mark.size()) == byte_order_mark)
      rest_.remove_prefix(byte_order_mark.size());
    while (!rest_.empty() && trimmed(rest_.substr(rest_.rfind('\n') + 1)).empty()) {
      // Nothing but blanks behind the last line's end: the table is over before it.
      const std::size_t end = rest_.rfind('\n');
      rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(0, end);
    }
    if (rest_.empty()) {
      faults_.add(1, "", "", "the table is empty: not even a header");
      return table_;
    }
    const std::string other = otherTableFormat(rest_);
    if (!other.empty()) {
      faults_.add(1, "", "", other);
      return table_;
    }
    readHeader(nextLine());
    const std::size_t first = rest_.find('\n');
    const std::size_t length = first == std::string_view::npos ? rest_.size() : first + 1;
    const std::size_t rows = length == 0 ? 0 : rest_.size() / length + rest_.size() / (4 * length) + 1;
    for (auto& column : table_.values) column.reserve(rows);
    while (!rest_.empty()) readRow(nextLine());
    if (table_.rows() == 0 && bad_ == 0) faults_.add(1, "", "", "the table has a header, but no rows");
    if (bad_ > max_cell_faults)
      faults_.add(0, "", "", "and " + std::to_string(bad_ - max_cell_faults) + " more bad cells or lines");
    return std::move(table_);
  }

 private:
  std::string_view nextLine() {
    ++line_;
    const std::size_t end = rest_.find('\n');
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    return line;
  }

  void readHeader(std::string_view line) {
    while (true) {
      const std::size_t comma = line.find(',');
      const std::string name(trimmed(line.substr(0, comma)));
      if (name.empty()) complain("", "", "a column has no name");
      if (table_.indexOf(name) >= 0) complain(name, "", "the column stands twice");
      table_.columns.push_back(name);
      if (comma == std::string_view::npos) break;
      line.remove_prefix(comma + 1);
    }
    table_.values.resize(table_.columns.size());
  }

  void readRow(std::string_view line) {
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    const char* at = line.data();
    const char* const end = at + line.size();
    const std::size_t count = table_.columns.size();
    for (std::size_t i = 0; i < count; ++i) {
      double value = 0.0;
      const auto result = std::from_chars(at, end, value);
      const bool whole = result.ec == std::errc() && (result.ptr == end || *result.ptr == ',');
      if (whole && std::isfinite(value)) {
        at = result.ptr;
      } else {
        at = readOddCell(at, end, i, value);
      }
      table_.values[i].push_back(value);
      const bool is_last = i + 1 == count;
      if (is_last ? at == end : at != end) {
        ++at;
        continue;
      }
      const auto cells = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
      complain("", "",
               "the line has " + std::to_string(cells) + " cells, the header " + std::to_string(count) +
                   (rest_.empty() ? " (the file ends in the middle of a line)" : ""));
      for (std::size_t j = i + 1; j < count; ++j) table_.values[j].push_back(0.0);
      return;
    }
  }

  /// A cell with blanks or a plus, or one that is not a number: off the fast path.
  const char* readOddCell(const char* at, const char* end, std::size_t column, double& value) {
    const char* const stop = std::find(at, end, ',');
    const std::string_view cell = trimmed({at, static_cast<std::size_t>(stop - at)});
    const auto number = parseNumber(cell);
    value = number.value_or(0.0);
    if (!number)
      complain(table_.columns[column], printable(cell.substr(0, 40)),
               cell.empty() ? "the cell is empty" : "the cell must be a finite number");
    return stop;
  }

  void complain(const std::string& column, const std::string& value, const std::string& rule) {
    if (++bad_ <= max_cell_faults) faults_.add(line_, column, value, rule);
  }

  std::string_view rest_;
  FaultList& faults_;
  NumericTable table_;
  int line_ = 0;
  std::size_t bad_ = 0;
};

}  // namespace

std::string otherTableFormat(std::string_view text) {
  if (text.substr(0, 2) == "\x1f\x8b") return "the file is gzip-compressed; its name must end with .csv.gz";
  if (!holds(text, '\n') && std::count(text.begin(), text.end(), '\r') > 1)
    return "the lines end with CR alone; they must end with LF: tr '\\r' '\\n' < IN > OUT";
  if (holds(text.substr(0, 64), '\0')) return "the file is no plain text (UTF-16, or no table at all); save it as CSV in UTF-8";
  const std::string_view header = trimmed(firstLine(text));
  const std::string_view row = trimmed(firstLine(text.substr(std::min(text.size(), firstLine(text).size() + 1))));
  if (!header.empty() && header.front() == '#') return "the first line is a comment; a table begins with the names of its columns";
  if (holds(header, '"') || holds(row, '"')) return "names or numbers stand in quotation marks; take them out: tr -d '\"' < IN > OUT";
  if (!holds(header, ',')) return otherSeparator(header, row);
  const auto cells = [](std::string_view line) { return std::count(line.begin(), line.end(), ',') + 1; };
  // of "0,001,1,5" it cannot be told which commas part cells
  if (cells(row) > cells(header) && row.find_first_not_of("0123456789-,") == std::string_view::npos)
    return "the first row has " + std::to_string(cells(row)) + " cells of digits only for " + std::to_string(cells(header)) +
           " names: decimal commas part cells; export the numbers with decimal points";
  if (parseNumber(trimmed(header.substr(0, header.find(',')))))
    return "the first line holds numbers; a table has a header line with the names of its columns";
  return "";
}

int NumericTable::indexOf(const std::string& column) const {
  const auto found = std::find(columns.begin(), columns.end(), column);
  return found == columns.end() ? -1 : static_cast<int>(found - columns.begin());
}

NameWithUnit splitUnit(const std::string& name) {
  const std::size_t underscore = name.rfind('_');
  if (underscore == std::string::npos) return {name, ""};
  return {name.substr(0, underscore), name.substr(underscore + 1)};
}

std::string readCompressed(const std::string& path, FaultList& faults) {
  gzFile file = gzopen(path.c_str(), "rb");
  if (file == nullptr) {
    faults.add(0, "", "", "the file cannot be read");
    return "";
  }
  constexpr unsigned buffer_size = 1u << 18;
  gzbuffer(file, buffer_size);
  std::string text;
  int got = 0;
  do {
    const std::size_t size = text.size();
    text.resize(size + buffer_size);
    got = gzread(file, &text[size], buffer_size);
    text.resize(size + static_cast<std::size_t>(std::max(got, 0)));
  } while (got > 0 && text.size() <= max_table_bytes);
  const bool is_plain = gzdirect(file) != 0;
  int status = Z_OK;
  gzerror(file, &status);
  const int closed = gzclose(file);
  if (text.size() > max_table_bytes) {
    faults.add(0, "", "", "the file is larger than " + std::to_string(max_table_bytes) + " bytes");
  } else if (got < 0 || (status != Z_OK && status != Z_STREAM_END) || closed != Z_OK) {
    faults.add(0, "", "", "the compressed file is cut off or damaged");
  } else if (is_plain) {
    faults.add(0, "", "",
               text.empty() ? "the file is empty" : "the file is not compressed, but its name ends with .gz");
  }
  return text;
}

NumericTable parseTable(const std::string& text, FaultList& faults) {
  return TableParser(text, faults).parse();
}

NumericTable readTable(const std::string& path, FaultList& faults) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    faults.add(0, "", "", std::filesystem::exists(path, error) ? "is a folder, or no file at all" : "there is no such file");
    return {};
  }
  if (endsWith(path, ".csv.gz")) {
    const std::size_t before = faults.faults().size();
    const std::string text = readCompressed(path, faults);
    if (faults.faults().size() > before) return {};
    return parseTable(text, faults);
  }
  if (endsWith(path, ".csv")) return parseTable(readTextFile(path), faults);
  faults.add(0, "", "",
             endsWith(path, ".bag")
                 ? "a bag cannot be read here; turn it into a table first: amb convert IN.bag OUT.csv.gz"
                 : "a table must end with .csv or .csv.gz");
  return {};
}

}  // namespace amb_rotor
