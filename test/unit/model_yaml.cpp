// The YAML layer: lines, types, duplicates, aliases, numbers as text.
#include <cmath>
#include <limits>

#include "model_test_support.hpp"

namespace amb_rotor {
namespace {

using namespace model_test;

std::vector<Fault> syntaxFaults(const std::string& text) {
  return faultsOf([&] {
    FaultList faults("f.yaml");
    parseYaml(text, faults);
    faults.throwIfAny();
  });
}

TEST(ModelYaml, numbersReadBackToTheSameBits) {
  for (const double value :
       {0.0, 1.0, -3.0, 0.1, 1e-6, 3.38e7, 1e22, 5e-324, 1.7976931348623157e308, 1.0 / 3.0}) {
    const auto back = parseNumber(numberText(value));
    ASSERT_TRUE(back) << numberText(value);
    EXPECT_EQ(*back, value);
  }
  EXPECT_TRUE(std::signbit(*parseNumber(numberText(-0.0))));
  EXPECT_EQ(numberText(1e-6), "1.0e-06");  // a float for readers of YAML 1.1 too
  EXPECT_EQ(numberText(3.0), "3.0");
}

TEST(ModelYaml, whatIsNoFiniteNumberIsRefused) {
  for (const char* text :
       {"", "x", "1x", "0x10", "nan", ".nan", ".inf", "inf", "-inf", "1e999", "1,5", "1 2", "+-1"})
    EXPECT_FALSE(parseNumber(text)) << text;
  EXPECT_EQ(*parseNumber("+1.5"), 1.5);
}

TEST(ModelYaml, syntaxErrorHasItsLine) {
  const auto faults = syntaxFaults("a: 1\nb: [1, 2\nc: 3\n");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_GE(faults[0].line, 2);
  EXPECT_NE(faults[0].rule.find("not valid YAML"), std::string::npos);
}

TEST(ModelYaml, duplicateKeysAreFoundAtEveryLevel) {
  const auto faults = syntaxFaults("a: 1\nb:\n  - {c: 1, c: 2}\n  - d:\n      e: 1\n      e: 2\na: 2\n");
  ASSERT_EQ(faults.size(), 3u) << joined(faults);
  EXPECT_EQ(faultOf(faults, "b.0.c").line, 3);
  EXPECT_EQ(faultOf(faults, "b.1.d.e").line, 6);
  EXPECT_EQ(faultOf(faults, "a").line, 7);
}

TEST(ModelYaml, emptyAndSecondDocumentsAreFaults) {
  EXPECT_EQ(syntaxFaults("").size(), 1u);
  EXPECT_EQ(syntaxFaults("# only a comment\n").size(), 1u);
  EXPECT_EQ(syntaxFaults("a: 1\n---\nb: 2\n").size(), 1u);
}

TEST(ModelYaml, aliasesRepeatAndCannotGrowWithoutBound) {
  FaultList faults("f.yaml");
  const YamlNode root = parseYaml("a: &x {k: 1}\nb: *x\n", faults);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(root.find("b")->find("k")->text, "1");
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 10; ++k) bomb += last + (k < 9 ? " , " : " ]\n");
  }
  EXPECT_FALSE(syntaxFaults(bomb).empty());
}

TEST(ModelYaml, typesMissingAndUnknownKeysAreFaults) {
  FaultList faults("f.yaml");
  const YamlNode document =
      parseYaml("number: \"1\"\nnothing:\nword: [1]\nlist: 3\nmap: 4\ntypo: 1\nchoice: c\n", faults);
  YamlMap root(&document, "", faults);
  EXPECT_TRUE(std::isnan(root.number("number")));
  root.number("nothing");
  root.text("word");
  EXPECT_TRUE(root.list("list").empty());
  EXPECT_TRUE(std::isnan(root.map("map").number("inner")));  // reported once, not again for what is in it
  EXPECT_EQ(root.choice("choice", {"a", "b"}), -1);
  root.number("type");
  root.finish();
  EXPECT_EQ(faults.faults().size(), 8u) << joined(faults.faults());
  EXPECT_NE(faultOf(faults.faults(), "typo").rule.find("nearest: type"), std::string::npos);
  EXPECT_EQ(faultOf(faults.faults(), "choice").rule, "must be one of a, b");
  EXPECT_EQ(faultOf(faults.faults(), "number").value, "\"1\"");
}

TEST(ModelYaml, aBlockIsWrittenBackToTheSame) {
  const std::string text =
      "a: \"1\"\nb:\n  - c: x y\n    d: [1.5, true, null]\n  - []\ne: {}\n\"1\": \"tab\\there\"\n";
  FaultList faults("f.yaml");
  const std::string once = yamlText(parseYaml(text, faults), 0);
  EXPECT_EQ(yamlText(parseYaml(once, faults), 0), once);
  const YamlNode again = parseYaml(once, faults);
  EXPECT_FALSE(again.find("a")->plain);
  EXPECT_EQ(again.find("b")->items[0].find("c")->text, "x y");
  EXPECT_EQ(again.find("1")->text, "tab\there");
  EXPECT_TRUE(faults.empty());
}

TEST(ModelYaml, nearestWord) {
  EXPECT_EQ(nearestWord("mass", {"rig.rotor.mass_kg", "rig.amb.bias_current_A"}), "rig.rotor.mass_kg");
  EXPECT_EQ(nearestWord("mass_kg", {"kg", "rig.rotor.mass_kg"}), "rig.rotor.mass_kg");
  EXPECT_EQ(nearestWord("x", {}), "");
}

TEST(ModelYaml, aFileThatCannotBeReadIsABadInput) {
  EXPECT_EQ(faultsOf([] { readTextFile(dataFolder() + "/no_such_file.yaml"); }).size(), 1u);
  EXPECT_EQ(faultsOf([] { readTextFile(dataFolder()); }).size(), 1u);
  EXPECT_EQ(readFormat(dataFolder() + "/model_valid/model.yaml"), "amb-model/1");
}

}  // namespace
}  // namespace amb_rotor
