#include "amb_rotor/model/yaml_document.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace amb_rotor {
namespace {

/// Builds our tree out of yaml-cpp's events, which carry the lines.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(FaultList& faults) : faults_(faults) {}

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    close(open(mark, YamlNode::Kind::null), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchored_.find(anchor);
    YamlNode node;
    if (found != anchored_.end()) {
      node = found->second;
    } else {
      faults_.add(mark.line + 1, "", "", "an alias must not stand inside of what it repeats");
    }
    count(sizeOf(node), mark.line + 1);
    close(std::move(node), 0);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    YamlNode node = open(mark, YamlNode::Kind::scalar);
    node.text = value;
    node.plain = tag != "!";
    close(std::move(node), anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    push(open(mark, YamlNode::Kind::sequence), anchor);
  }
  void OnSequenceEnd() override { pop(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    push(open(mark, YamlNode::Kind::map), anchor);
  }
  void OnMapEnd() override { pop(); }

  YamlNode root;

 private:
  struct Frame {
    YamlNode node;
    YAML::anchor_t anchor = 0;
    bool key_is_open = false;
    std::set<std::string> seen;
  };

  YamlNode open(const YAML::Mark& mark, YamlNode::Kind kind) {
    count(1, mark.line + 1);
    YamlNode node;
    node.kind = kind;
    node.line = mark.line + 1;
    return node;
  }
  void count(std::size_t more, int line) {
    nodes_ += more;
    if (nodes_ <= max_yaml_nodes) return;
    faults_.add(line, "", "", "the document is larger than " + std::to_string(max_yaml_nodes) + " values");
    faults_.throwIfAny();
  }
  static std::size_t sizeOf(const YamlNode& node) {
    std::size_t size = 1;
    for (const YamlNode& item : node.items) size += sizeOf(item);
    return size;
  }
  void push(YamlNode node, YAML::anchor_t anchor) {
    Frame frame;
    frame.node = std::move(node);
    frame.anchor = anchor;
    frames_.push_back(std::move(frame));
  }
  void pop() {
    Frame frame = std::move(frames_.back());
    frames_.pop_back();
    close(std::move(frame.node), frame.anchor);
  }
  /// A node is complete: put it where it belongs.
  void close(YamlNode node, YAML::anchor_t anchor) {
    if (anchor != 0) anchored_[anchor] = node;
    if (frames_.empty()) {
      root = std::move(node);
      return;
    }
    Frame& frame = frames_.back();
    if (frame.node.kind == YamlNode::Kind::map && !frame.key_is_open) {
      addKey(frame, node);
    } else {
      // The event of an empty value comes with the place of what follows it.
      if (node.kind == YamlNode::Kind::null && frame.key_is_open) node.line = frame.node.key_lines.back();
      frame.node.items.push_back(std::move(node));
      frame.key_is_open = false;
    }
  }
  void addKey(Frame& frame, const YamlNode& key) {
    if (key.kind != YamlNode::Kind::scalar) {
      faults_.add(key.line, "", "", "a key must be a plain word");
    } else if (!frame.seen.insert(key.text).second) {
      faults_.add(key.line, pathOf(key.text), "", "the key stands twice in the same map");
    }
    frame.node.keys.push_back(key.text);
    frame.node.key_lines.push_back(key.line);
    frame.key_is_open = true;
  }
  std::string pathOf(const std::string& key) const {
    std::string path;
    for (std::size_t i = 0; i + 1 < frames_.size(); ++i) {
      const YamlNode& node = frames_[i].node;
      const bool in_map = node.kind == YamlNode::Kind::map;
      if (in_map && node.keys.empty()) continue;
      path += (in_map ? node.keys.back() : std::to_string(node.items.size())) + ".";
    }
    return path + key;
  }

  FaultList& faults_;
  std::vector<Frame> frames_;
  std::map<YAML::anchor_t, YamlNode> anchored_;
  std::size_t nodes_ = 0;
};

/// Whether bytes are UTF-8 text from `at` on; moves `at` past one character.
bool isCharacter(const std::string& text, std::size_t& at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  const std::size_t more = first < 0x80 ? 0 : first >= 0xc2 && first < 0xe0 ? 1 : first >= 0xe0 && first < 0xf0 ? 2 : 3;
  if (first == 0 || (first >= 0x80 && first < 0xc2) || first >= 0xf5) return false;
  for (std::size_t i = 1; i <= more; ++i)
    if (byte(at + i) < 0x80 || byte(at + i) >= 0xc0) return false;
  at += more + 1;
  return true;
}

/// What is no text is one fault; its bytes would go into messages and names.
void requireText(const std::string& text, FaultList& faults) {
  for (std::size_t at = 0; at < text.size();) {
    if (isCharacter(text, at)) continue;
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    const bool other = text.find('\0') != std::string::npos;
    faults.add(static_cast<int>(line), "", "",
               other ? "is no text file" : "is no text in UTF-8; from Latin-1: iconv -f latin1 -t utf-8 IN > OUT");
    faults.throwIfAny();
  }
}

}  // namespace

const YamlNode* YamlNode::find(const std::string& key) const {
  if (kind != Kind::map) return nullptr;
  const auto found = std::find(keys.begin(), keys.end(), key);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}

void FaultList::add(int line, const std::string& key, const std::string& value, const std::string& rule) {
  faults_.push_back({file_, line, key, value, rule});
}

void FaultList::addRules(const std::vector<Fault>& faults) {
  std::set<std::string> reported;
  for (const Fault& fault : faults_) reported.insert(fault.key);
  for (const Fault& fault : located(faults))
    if (reported.count(fault.key) == 0) faults_.push_back(fault);
}

std::vector<Fault> FaultList::located(const std::vector<Fault>& faults) const {
  std::vector<Fault> all;
  for (const Fault& fault : faults) {
    const auto place = places_.find(fault.key);
    const bool is_written = place != places_.end() && !place->second.second.empty();
    if (place != places_.end() && place->second.first == 0)
      all.push_back(fault);
    else
      all.push_back({file_, lineOf(fault.key), fault.key, is_written ? place->second.second : fault.value, fault.rule});
  }
  return all;
}

void FaultList::append(const std::vector<Fault>& faults) {
  faults_.insert(faults_.end(), faults.begin(), faults.end());
}

int FaultList::lineOf(std::string path) const {
  while (true) {
    const auto found = places_.find(path);
    if (found != places_.end()) return found->second.first;
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos) return 0;
    path.resize(dot);
  }
}

void FaultList::throwIfAny() const {
  if (faults_.empty()) return;
  std::vector<Fault> sorted = faults_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Fault& a, const Fault& b) { return a.file == b.file && a.line < b.line; });
  throw InputError(sorted);
}

std::string readTextFile(const std::string& path) {
  std::error_code ignored;
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (std::filesystem::is_directory(path, ignored)) throw InputError({{path, 0, "", "", "is a folder, not a file"}});
  if (!stream.is_open())
    throw InputError({{path, 0, "", "", std::string("the file cannot be read: ") + std::strerror(errno)}});
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

YamlNode parseYaml(const std::string& text, FaultList& faults) {
  requireText(text, faults);
  std::istringstream stream(text);
  TreeBuilder builder(faults);
  try {
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) {
      faults.add(1, "", "", "the file is empty");
      faults.throwIfAny();
    }
    TreeBuilder second(faults);
    if (parser.HandleNextDocument(second))
      faults.add(second.root.line, "", "", "a file holds one document; here begins a second one");
  } catch (const YAML::Exception& error) {
    faults.add(error.mark.is_null() ? 0 : error.mark.line + 1, "", "", "not valid YAML: " + error.msg);
    faults.throwIfAny();
  }
  return std::move(builder.root);
}

std::string readFormat(const std::string& path) {
  FaultList faults(path);
  const YamlNode root = parseYaml(readTextFile(path), faults);
  const YamlNode* format = root.find("format");
  return format != nullptr && format->kind == YamlNode::Kind::scalar ? format->text : "";
}

void requireFormat(YamlMap& root, const std::string& format) {
  const std::string found = root.text("format");
  if (found == format) return;
  if (!found.empty()) root.fault("format", "must be " + format);
  root.faults().throwIfAny();
}

}  // namespace amb_rotor
