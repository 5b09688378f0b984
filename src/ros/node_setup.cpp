#include "amb_rotor/ros/node_setup.hpp"

#include <algorithm>
#include <iterator>
#include <sstream>

#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/machine/model_loading.hpp"
#include "amb_rotor/model/model_reader.hpp"
#include "amb_rotor/model/overrides.hpp"
#include "amb_rotor/model/scenario_reader.hpp"

namespace amb_rotor {
namespace {

[[noreturn]] void wrong(const ros::NodeHandle& own, const std::string& name, const std::string& rule) {
  throw InputError({{"", 0, own.getNamespace() + "/" + name, "", rule}});
}

template <class T>
T valueOr(const ros::NodeHandle& own, const std::string& name, const T& otherwise, const char* kind) {
  std::string key;
  if (!own.searchParam(name, key)) return otherwise;
  T value;
  if (!own.getParam(key, value)) wrong(own, name, std::string("this parameter must be ") + kind);
  return value;
}

}  // namespace

std::string requiredText(const ros::NodeHandle& own, const std::string& name) {
  const std::string value = textOr(own, name, "");
  if (value.empty()) wrong(own, name, "this parameter is missing (a text)");
  return value;
}

double numberOr(const ros::NodeHandle& own, const std::string& name, double otherwise) {
  return valueOr(own, name, otherwise, "a number");
}

int integerOr(const ros::NodeHandle& own, const std::string& name, int otherwise) {
  return valueOr(own, name, otherwise, "a whole number");
}

bool switchOr(const ros::NodeHandle& own, const std::string& name, bool otherwise) {
  return valueOr(own, name, otherwise, "true or false");
}

std::string textOr(const ros::NodeHandle& own, const std::string& name, const std::string& otherwise) {
  return valueOr(own, name, otherwise, "a text");
}

std::vector<std::string> wordsOf(const ros::NodeHandle& own, const std::string& name) {
  std::istringstream text(textOr(own, name, ""));
  return {std::istream_iterator<std::string>(text), std::istream_iterator<std::string>()};
}

bool areAdvertised(const ros::NodeHandle& nodes, const std::vector<std::string>& topics) {
  if (topics.empty()) return true;
  ros::master::V_TopicInfo known;
  if (!ros::master::getTopics(known)) return false;
  return std::all_of(topics.begin(), topics.end(), [&](const std::string& topic) {
    return std::any_of(known.begin(), known.end(), [&](const ros::master::TopicInfo& info) {
      return info.name == nodes.resolveName(topic);
    });
  });
}

Model modelOf(const ros::NodeHandle& own) {
  Model model = readModel(requiredText(own, "model"), effectCatalogue());
  const auto overrides = valueOr(own, "overrides", std::vector<std::string>(), "a list of texts path=value");
  if (!overrides.empty()) applyOverrides(model, overrides, effectCatalogue());
  fillFlexibleModes(model);
  return model;
}

Scenario scenarioOf(const ros::NodeHandle& own) { return readScenario(requiredText(own, "scenario")); }

}  // namespace amb_rotor
