// Formulas of effect files: every function against std, for double and for lanes; precedence; all faults at once, each
// with line and column.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "amb_rotor/model/expression.hpp"

namespace amb_rotor {
namespace {

const std::vector<std::string> names = {"x", "y", "k_N_per_m"};

Expression compiled(const std::string& text) {
  std::vector<FormulaFault> faults;
  const Expression out = Expression::compile(text, names, faults);
  for (const auto& fault : faults) ADD_FAILURE() << text << ": " << fault.line << ":" << fault.column << " " << fault.rule;
  return out;
}

double value(const std::string& text, double x = 0.3, double y = -0.8, double k = 5.0) {
  const double variables[] = {x, y, k};
  return compiled(text).evaluate(variables);
}

std::vector<FormulaFault> formulaFaults(const std::string& text) {
  std::vector<FormulaFault> faults;
  const Expression out = Expression::compile(text, names, faults);
  const double variables[] = {1.0, 2.0, 3.0};
  if (!faults.empty()) {
    EXPECT_EQ(out.evaluate(variables), 0.0) << text;
  }
  return faults;
}

TEST(FormulaTest, BindsAsInMathematics) {
  // Small whole numbers: exact.
  EXPECT_EQ(value("1 + 2 * 3"), 7.0);
  EXPECT_EQ(value("(1 + 2) * 3"), 9.0);
  EXPECT_EQ(value("8 / 4 / 2"), 1.0);
  EXPECT_EQ(value("8 - 4 - 2"), 2.0);
  EXPECT_EQ(value("-2^2"), -4.0);
  EXPECT_EQ(value("(-2)^2"), 4.0);
  EXPECT_EQ(value("2^3^2"), 512.0);
  EXPECT_EQ(value("2^-2"), 0.25);
  EXPECT_EQ(value("2*-3"), -6.0);
  EXPECT_EQ(value("- - 3"), 3.0);
  EXPECT_EQ(value("1.5e+1 - .5"), 14.5);
  EXPECT_EQ(value("x\n + y\t*\n k_N_per_m"), 0.3 - 0.8 * 5.0);
  EXPECT_EQ(value("max(min(x, y), -0.5)"), -0.5);
}

struct Known {
  const char* text;
  std::function<double(double, double)> exact;
  bool positive;  ///< the first argument must be above 0
};

const std::vector<Known> known = {
    {"sin(x)", [](double x, double) { return std::sin(x); }, false},
    {"cos(x)", [](double x, double) { return std::cos(x); }, false},
    {"tan(x)", [](double x, double) { return std::tan(x); }, false},
    {"atan(x)", [](double x, double) { return std::atan(x); }, false},
    {"sqrt(x)", [](double x, double) { return std::sqrt(x); }, true},
    {"exp(x)", [](double x, double) { return std::exp(x); }, false},
    {"log(x)", [](double x, double) { return std::log(x); }, true},
    {"tanh(x)", [](double x, double) { return std::tanh(x); }, false},
    {"abs(x)", [](double x, double) { return std::fabs(x); }, false},
    {"sign(x)", [](double x, double) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }, false},
    {"step(x)", [](double x, double) { return x > 0.0 ? 1.0 : 0.0; }, false},
    {"min(x, y)", [](double x, double y) { return std::fmin(x, y); }, false},
    {"max(x, y)", [](double x, double y) { return std::fmax(x, y); }, false},
    {"hypot(x, y)", [](double x, double y) { return std::hypot(x, y); }, false},
    {"atan2(x, y)", [](double x, double y) { return std::atan2(x, y); }, false},
    {"x^y", [](double x, double y) { return std::pow(x, y); }, true},
    {"x^5", [](double x, double) { return std::pow(x, 5.0); }, false},
    {"x^-3", [](double x, double) { return std::pow(x, -3.0); }, false},
    {"x^2.5", [](double x, double) { return std::pow(x, 2.5); }, true},
    {"pi * x", [](double x, double) { return M_PI * x; }, false}};

TEST(FormulaTest, EveryFunctionIsThatOfTheStandardLibrary) {
  std::string all;
  for (const auto& k : known) all += k.text;
  for (const auto& function : formulaFunctions())
    EXPECT_NE(all.find(function + "("), std::string::npos) << function << " is not tested";
  using Pack = Lanes<xsimd::default_arch>;
  // Few units in the last place of the vector library, some ten of exp(y log x); tan and the powers condition those by
  // at most 20 over these arguments.
  constexpr double tolerance = 2e-14;
  const double arguments[] = {-2.7, -1.0, -0.4, 1e-3, 0.4, 1.0, 1.3, 2.7};
  for (const auto& k : known) {
    const Expression formula = compiled(k.text);
    for (double x : arguments)
      for (double y : arguments) {
        if (k.positive && x <= 0.0) continue;
        const double exact = k.exact(x, y), bound = tolerance * std::fmax(1.0, std::fabs(exact));
        const double variables[] = {x, y, 0.0};
        EXPECT_NEAR(formula.evaluate(variables), exact, bound) << k.text << " at " << x << ", " << y;
        // each lane its own argument
        Pack lanes[3] = {Pack(x), Pack(y), Pack(0.0)};
        setLane(lanes[0], 0, k.positive ? 0.7 : -0.7);
        const Pack result = formula.evaluate(lanes);
        EXPECT_NEAR(laneValue(result, Pack::size - 1), exact, bound) << k.text << " in lanes, at " << x << ", " << y;
        const double first = k.exact(k.positive ? 0.7 : -0.7, y);
        EXPECT_NEAR(laneValue(result, 0), first, tolerance * std::fmax(1.0, std::fabs(first))) << k.text;
      }
  }
}

TEST(FormulaTest, EdgesOfThePower) {
  EXPECT_EQ(value("x^2.5", 0.0), 0.0);
  EXPECT_EQ(value("x^y", 0.0, 0.0), 1.0);
  EXPECT_TRUE(std::isnan(value("x^2.5", -1.0))) << "there is no real one";
  EXPECT_EQ(value("sign(x) + step(x)", 0.0), 0.0);
}

TEST(FormulaTest, AllFaultsAtOnceWithTheirPlace) {
  const auto faults = formulaFaults("k * (x + $3) \n + sin(x, y) * foo(y) + 1.2.3");
  ASSERT_EQ(faults.size(), 5u);
  EXPECT_EQ(faults[0].line, 1);
  EXPECT_EQ(faults[0].column, 1);
  EXPECT_NE(faults[0].rule.find("nearest"), std::string::npos) << faults[0].rule;
  EXPECT_EQ(faults[1].column, 10) << faults[1].rule;
  EXPECT_NE(faults[1].rule.find("'$'"), std::string::npos);
  EXPECT_EQ(faults[2].line, 2);
  EXPECT_EQ(faults[2].column, 4);
  EXPECT_NE(faults[2].rule.find("it takes 1"), std::string::npos) << faults[2].rule;
  EXPECT_EQ(faults[3].column, 16);
  EXPECT_NE(faults[3].rule.find("no function 'foo'"), std::string::npos) << faults[3].rule;
  EXPECT_EQ(faults[4].column, 25);
  EXPECT_NE(faults[4].rule.find("no number"), std::string::npos) << faults[4].rule;
}

TEST(FormulaTest, EachKindOfMistakeIsNamed) {
  const auto only = [](const std::string& text, int column, const std::string& part) {
    const auto faults = formulaFaults(text);
    ASSERT_EQ(faults.size(), 1u) << text;
    EXPECT_EQ(faults[0].column, column) << text << ": " << faults[0].rule;
    EXPECT_NE(faults[0].rule.find(part), std::string::npos) << text << ": " << faults[0].rule;
  };
  only("", 1, "empty");
  only("x +", 4, "missing at the end");
  only("x * * y", 5, "missing before '*'");
  only("(x + y", 1, "not closed");
  only("x + y)", 6, "no parenthesis is open");
  only("x y", 3, "operator may be missing");
  only("sin x", 1, "needs its arguments");
  only("x(2)", 1, "is a value, not a function");
  only("hypot(x)", 1, "it takes 2");
  only("sin()", 1, "has 0 arguments");
  only("x + ;y", 5, "';'");
  only("\xC3\xA9 + x", 1, "has no meaning");
  only(std::string(60, '(') + "x" + std::string(60, ')'), 42, "nested more than 40");
  only(std::string(5000, '1'), 1, "longer than");
}

TEST(FormulaTest, ADeepStackIsRefusedNotOverrun) {
  // right-hand chains keep every value: 1+(1+(1+ ... is bounded by the nesting, this one by the stack
  std::string text = "x";
  for (int i = 0; i < 38; ++i) text = "x + (" + text + ")";
  const auto faults = formulaFaults(text);
  ASSERT_FALSE(faults.empty());
  EXPECT_NE(faults[0].rule.find("values at a time"), std::string::npos) << faults[0].rule;
  for (int depth = 2; depth < Expression::most_depth; ++depth) {
    std::string inner = "x";
    for (int i = 1; i < depth; ++i) inner = "x + (" + inner + ")";
    EXPECT_NEAR(value(inner, 0.5), 0.5 * depth, 1e-12);
  }
}

TEST(FormulaTest, KnowsWhatItReads) {
  const Expression formula = compiled("x^2 + 3");
  EXPECT_TRUE(formula.reads(0));
  EXPECT_FALSE(formula.reads(1));
}

}  // namespace
}  // namespace amb_rotor
