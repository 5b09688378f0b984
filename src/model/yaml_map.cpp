#include <algorithm>
#include <limits>

#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

constexpr double missing_number = std::numeric_limits<double>::quiet_NaN();

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string kindText(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::null:
      return "nothing";
    case YamlNode::Kind::scalar:
      return node.text;
    case YamlNode::Kind::sequence:
      return "a list";
    case YamlNode::Kind::map:
      return "a map";
  }
  return "";
}

}  // namespace

YamlMap::YamlMap(const YamlNode* node, std::string path, FaultList& faults)
    : node_(node), path_(std::move(path)), faults_(&faults) {
  if (node_ == nullptr) return;
  faults.noteLine(path_, node_->line);
  if (node_->kind == YamlNode::Kind::map) return;
  faults.add(node_->line, path_, kindText(*node_), "must be a map of keys and values");
  node_ = nullptr;
}

const std::vector<std::string>& YamlMap::keys() const {
  static const std::vector<std::string> none;
  return node_ != nullptr ? node_->keys : none;
}

const YamlNode* YamlMap::take(const std::string& key, bool required) {
  known_.push_back(key);
  if (node_ == nullptr) return nullptr;
  const YamlNode* value = node_->find(key);
  if (value == nullptr) {
    if (required) faults_->add(node_->line, pathOf(key), "", "the key is missing");
    return nullptr;
  }
  faults_->noteLine(pathOf(key), value->line, value->text);
  if (value->kind == YamlNode::Kind::null) {
    faults_->add(value->line, pathOf(key), "", "the key has no value");
    return nullptr;
  }
  return value;
}

bool YamlMap::has(const std::string& key) {
  known_.push_back(key);
  return node_ != nullptr && node_->find(key) != nullptr;
}

double YamlMap::numberOf(const YamlNode& node, const std::string& path) {
  if (node.kind == YamlNode::Kind::scalar && node.plain) {
    const auto value = parseNumber(node.text);
    if (value) return *value;
  }
  const std::string quotes = node.kind == YamlNode::Kind::scalar && !node.plain ? "\"" : "";
  faults_->add(node.line, path, quotes + kindText(node) + quotes, "must be a finite number");
  return missing_number;
}

double YamlMap::number(const std::string& key) {
  const YamlNode* value = take(key, true);
  return value != nullptr ? numberOf(*value, pathOf(key)) : missing_number;
}

std::optional<double> YamlMap::optionalNumber(const std::string& key) {
  if (!has(key)) return std::nullopt;
  return number(key);
}

std::string YamlMap::text(const std::string& key) {
  const YamlNode* value = take(key, true);
  if (value == nullptr) return "";
  if (value->kind == YamlNode::Kind::scalar && !value->text.empty()) return value->text;
  faults_->add(value->line, pathOf(key), kindText(*value), "must be a text");
  return "";
}

int YamlMap::choice(const std::string& key, const std::vector<std::string>& choices) {
  const std::string word = text(key);
  const auto found = std::find(choices.begin(), choices.end(), word);
  if (found != choices.end()) return static_cast<int>(found - choices.begin());
  if (!word.empty())
    fault(key, "must be " + std::string(choices.size() > 1 ? "one of " : "") + listed(choices));
  return -1;
}

YamlMap YamlMap::map(const std::string& key) { return {take(key, true), pathOf(key), *faults_}; }

std::vector<YamlNode> YamlMap::list(const std::string& key) {
  const YamlNode* value = take(key, true);
  if (value == nullptr) return {};
  if (value->kind == YamlNode::Kind::sequence) return value->items;
  faults_->add(value->line, pathOf(key), kindText(*value), "must be a list");
  return {};
}

std::vector<double> YamlMap::numbers(const std::string& key) {
  std::vector<double> values;
  for (const YamlNode& item : list(key))
    values.push_back(numberOf(item, pathOf(key) + "." + std::to_string(values.size())));
  return values;
}

void YamlMap::fault(const std::string& key, const std::string& rule) {
  const YamlNode* value = node_ != nullptr ? node_->find(key) : nullptr;
  if (value == nullptr) {
    faults_->add(line(), pathOf(key), "", rule);
  } else {
    faults_->add(value->line, pathOf(key), kindText(*value), rule);
  }
}

void YamlMap::finish() {
  if (node_ == nullptr) return;
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    const std::string& key = node_->keys[i];
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string rule = "the key is not known here";
    if (!known_.empty()) rule += "; nearest: " + nearestWord(key, known_);
    faults_->add(node_->key_lines[i], pathOf(key), kindText(node_->items[i]), rule);
  }
}

}  // namespace amb_rotor
