// Scalars as text, and a node written back.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

bool isPlainSafe(const std::string& text) {
  if (text.empty() || parseNumber(text)) return false;
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '/';
  };
  if (!letter(text.front())) return false;
  for (const char c : text)
    if (!letter(c) && !(c >= '0' && c <= '9') && c != '.' && c != '-') return false;
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* word : {"null", "true", "false", "yes", "no", "on", "off", "y", "n"})
    if (lower == word) return false;
  return true;
}

std::string scalarText(const YamlNode& node) {
  if (node.kind == YamlNode::Kind::null) return "null";
  const bool number = node.plain && parseNumber(node.text);
  const bool truth = node.plain && (node.text == "true" || node.text == "false");
  return number || truth ? node.text : quotedText(node.text);
}

bool isBlock(const YamlNode& node) {
  return (node.kind == YamlNode::Kind::map || node.kind == YamlNode::Kind::sequence) && !node.items.empty();
}

/// What stands behind "key:" or "-": a scalar in the same line, or a block in the lines below.
std::string valueText(const YamlNode& node, int indent) {
  if (isBlock(node)) return "\n" + yamlText(node, indent);
  if (node.kind == YamlNode::Kind::map) return " {}\n";
  if (node.kind == YamlNode::Kind::sequence) return " []\n";
  return " " + scalarText(node) + "\n";
}

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

std::string yamlText(const YamlNode& node, int indent) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  std::string text;
  if (!isBlock(node)) return margin + valueText(node, 0).substr(1);
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    const std::string head =
        node.kind == YamlNode::Kind::map ? quotedText(node.keys[i]) + ":" : std::string("-");
    text += margin + head + valueText(node.items[i], indent + 2);
  }
  return text;
}

std::optional<double> parseNumber(std::string_view text) {
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && text.front() == '-') return std::nullopt;
  }
  double value = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

std::string numberText(double value) {
  char buffer[40];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  std::string text(buffer, result.ptr);
  if (!std::isfinite(value) || text.find('.') != std::string::npos) return text;
  const std::size_t exponent = text.find('e');
  return exponent == std::string::npos ? text + ".0" : text.insert(exponent, ".0");
}

std::string quotedText(const std::string& text) {
  if (isPlainSafe(text)) return text;
  static const char* digits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (code < 0x20 || code == 0x7f) {
      quoted += std::string("\\x") + digits[code >> 4] + digits[code & 15];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string nearestWord(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t least = 0;
  for (const std::string& candidate : candidates) {
    std::size_t distance = 2 * editDistance(word, candidate);
    // "mass_kg" means rig.rotor.mass_kg, though most of its letters are missing.
    const bool is_tail = candidate.size() > word.size() &&
                         candidate.compare(candidate.size() - word.size(), word.size(), word) == 0 &&
                         candidate[candidate.size() - word.size() - 1] == '.';
    if (is_tail) distance = 1;
    if (best.empty() || distance < least) {
      best = candidate;
      least = distance;
    }
  }
  return best;
}

}  // namespace amb_rotor
