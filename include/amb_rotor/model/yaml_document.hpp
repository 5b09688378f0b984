#pragma once
// Reading YAML that a person wrote: every value with its line, every fault collected, nothing defaulted
// in silence. All readers of this package go through YamlMap.
//
// Rules: a key may stand once in its map; keys that no reader asks for are faults; numbers are plain
// decimal text and finite (.nan, .inf, quoted numbers and hexadecimals are faults); a key without value
// is a fault. Aliases and anchors are understood; a document holds at most max_yaml_nodes nodes with
// what its aliases repeat.
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "amb_rotor/common/error.hpp"

namespace amb_rotor {

constexpr std::size_t max_yaml_nodes = 1000000;

/// A node of the document as it was written.
struct YamlNode {
  enum class Kind { null, scalar, sequence, map };
  Kind kind = Kind::null;
  int line = 0;                   ///< 1-based
  std::string text;               ///< scalar
  bool plain = true;              ///< scalar: without quotes
  std::vector<std::string> keys;  ///< map: key i belongs to items[i]
  std::vector<int> key_lines;
  std::vector<YamlNode> items;  ///< sequence, map

  const YamlNode* find(const std::string& key) const;
};

/// Collects what is wrong in one file.
class FaultList {
 public:
  explicit FaultList(std::string file) : file_(std::move(file)) {}
  const std::string& file() const { return file_; }
  bool empty() const { return faults_.empty(); }
  const std::vector<Fault>& faults() const { return faults_; }

  void add(int line, const std::string& key, const std::string& value, const std::string& rule);
  /// Adds faults of a rule check (without file and line): gives them both, and leaves out those of a
  /// key that has a fault already.
  void addRules(const std::vector<Fault>& faults);
  /// Such faults with file and line; as they are where the value was forgotten.
  std::vector<Fault> located(const std::vector<Fault>& faults) const;
  /// Adds faults that know their file and line.
  void append(const std::vector<Fault>& faults);
  /// Remembers where a value of this dotted path stands and how it was written, for addRules().
  void noteLine(const std::string& path, int line, const std::string& written = "") {
    places_[path] = {line, written};
  }
  /// The value of this path is no longer the file's.
  void forget(const std::string& path) { places_[path] = {0, ""}; }
  /// The line of the path, or of its nearest ancestor that has one; else 0.
  int lineOf(std::string path) const;
  /// Throws InputError with all faults in the order of their lines, if there is one.
  void throwIfAny() const;

 private:
  std::string file_;
  std::vector<Fault> faults_;
  std::map<std::string, std::pair<int, std::string>> places_;
};

/// The text of a file. Throws InputError if it cannot be read.
std::string readTextFile(const std::string& path);

/// The root of a YAML text of one document. Duplicate keys go to `faults`; a syntax error throws
/// InputError with its line (nothing behind it can be read).
YamlNode parseYaml(const std::string& text, FaultList& faults);

/// The node as YAML text, block style, each line indented by `indent` blanks. Reads back to the same.
std::string yamlText(const YamlNode& node, int indent);

/// A finite decimal number that fills the whole text (a leading + is allowed); empty: it is none.
std::optional<double> parseNumber(std::string_view text);

/// The shortest text that reads back to the same bits, as a YAML 1.1 float (1.0e-06, 3.0).
std::string numberText(double value);

/// A text as a YAML scalar, in double quotes where it needs them.
std::string quotedText(const std::string& text);

/// The candidate that differs least from `word` (empty without candidates).
std::string nearestWord(const std::string& word, const std::vector<std::string>& candidates);

/// One map of the document, being read. Values that are missing or wrong are reported to the FaultList
/// once and come back as NaN, an empty text, or an empty map or list that reports nothing more.
class YamlMap {
 public:
  /// `path`: dotted path of this map, empty for the root.
  YamlMap(const YamlNode* node, std::string path, FaultList& faults);

  bool valid() const { return node_ != nullptr; }
  int line() const { return node_ ? node_->line : 0; }
  const std::string& path() const { return path_; }
  std::string pathOf(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  FaultList& faults() const { return *faults_; }
  const std::vector<std::string>& keys() const;

  bool has(const std::string& key);                              ///< and declares the key as known
  double number(const std::string& key);                         ///< required
  std::optional<double> optionalNumber(const std::string& key);  ///< empty where the key is absent
  std::string text(const std::string& key);                      ///< required, not empty
  /// Required, one of the choices; returns its index, -1 where it is none of them.
  int choice(const std::string& key, const std::vector<std::string>& choices);
  YamlMap map(const std::string& key);                  ///< required
  std::vector<YamlNode> list(const std::string& key);   ///< required, may be empty
  std::vector<double> numbers(const std::string& key);  ///< required list of numbers
  /// Takes the key as known; a null pointer where it is missing (then reported, if required).
  const YamlNode* take(const std::string& key, bool required);
  /// A fault at the value of `key` (or at this map where it is absent).
  void fault(const std::string& key, const std::string& rule);
  /// To be called when all keys were asked for: reports those that are not known.
  void finish();

 private:
  double numberOf(const YamlNode& node, const std::string& path);

  const YamlNode* node_;
  std::string path_;
  FaultList* faults_;
  std::vector<std::string> known_;
};

/// The `format` of a YAML file ("amb-model/1", ...); empty where it has none. Throws on syntax errors.
std::string readFormat(const std::string& path);

/// Checks the root's `format`; throws InputError at once if it is another one, for then nothing else in
/// the file can be judged.
void requireFormat(YamlMap& root, const std::string& format);

}  // namespace amb_rotor
