#include "amb_rotor/model/expression.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/model/yaml_document.hpp"

namespace amb_rotor {
namespace {

using Op = Expression::Op;

constexpr int most_nesting = 40;
constexpr std::size_t most_characters = 4000;
constexpr double largest_whole_power = 16.0;

struct Function {
  const char* name;
  Op op;
  int arguments;
};
constexpr Function functions[] = {
    {"sin", Op::sine, 1},          {"cos", Op::cosine, 1},      {"tan", Op::tangent, 1},
    {"atan", Op::arc_tangent, 1},  {"sqrt", Op::square_root, 1}, {"exp", Op::exponential, 1},
    {"log", Op::logarithm, 1},     {"tanh", Op::hyperbolic_tangent, 1}, {"abs", Op::magnitude, 1},
    {"sign", Op::sign, 1},         {"step", Op::step, 1},       {"min", Op::minimum, 2},
    {"max", Op::maximum, 2},       {"hypot", Op::hypotenuse, 2}, {"atan2", Op::arc_tangent_2, 2}};

const Function* functionOf(const std::string& name) {
  const auto found = std::find_if(std::begin(functions), std::end(functions),
                                  [&](const Function& f) { return name == f.name; });
  return found == std::end(functions) ? nullptr : found;
}

struct Token {
  enum class Kind { number, name, mark, end } kind = Kind::end;
  std::string text;
  double value = 0.0;
  int line = 1, column = 1;
};

/// Cuts the text; characters that belong to nothing are faults and left out.
std::vector<Token> tokensOf(const std::string& text, std::vector<FormulaFault>& faults) {
  std::vector<Token> tokens;
  int line = 1, column = 1;
  std::size_t i = 0;
  const auto isWord = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  while (i < text.size()) {
    const char c = text[i];
    std::size_t length = 1;
    Token token;
    token.line = line;
    token.column = column;
    if (std::isdigit(static_cast<unsigned char>(c)) || c == '.') {
      length = 0;
      while (i + length < text.size()) {
        const char d = text[i + length];
        const bool exponent_sign = (d == '+' || d == '-') && length > 0 && (text[i + length - 1] == 'e' || text[i + length - 1] == 'E');
        if (!isWord(d) && d != '.' && !exponent_sign) break;
        ++length;
      }
      token.kind = Token::Kind::number;
      token.text = text.substr(i, length);
      const auto value = parseNumber(token.text);
      if (value) token.value = *value;
      else faults.push_back({line, column, "'" + token.text + "' is no number"});
      tokens.push_back(token);
    } else if (isWord(c)) {
      while (i + length < text.size() && isWord(text[i + length])) ++length;
      token.kind = Token::Kind::name;
      token.text = text.substr(i, length);
      tokens.push_back(token);
    } else if (std::string("+-*/^(),").find(c) != std::string::npos) {
      token.kind = Token::Kind::mark;
      token.text = std::string(1, c);
      tokens.push_back(token);
    } else if (c == '\n') {
      ++line;
      column = 0;
    } else if (c != ' ' && c != '\t' && c != '\r') {
      while (i + length < text.size() && (static_cast<unsigned char>(text[i + length]) & 0xC0) == 0x80) ++length;
      faults.push_back({line, column, "'" + text.substr(i, length) + "' has no meaning in a formula"});
    }
    i += length;
    column += static_cast<int>(length);
  }
  Token end;
  end.line = line;
  end.column = column;
  tokens.push_back(end);
  return tokens;
}

/// Recursive descent that goes on behind a fault.
class Parser {
 public:
  Parser(std::vector<Token> tokens, const std::vector<std::string>& names, std::vector<FormulaFault>& faults)
      : tokens_(std::move(tokens)), names_(names), faults_(faults) {}

  std::vector<Expression::Instruction> parse() {
    if (now().kind == Token::Kind::end) {
      fault(now(), "the formula is empty");
      return {};
    }
    sum();
    while (now().kind != Token::Kind::end) {
      fault(now(), "'" + now().text + "' is not expected here" +
                       (isMark(")") ? " (no parenthesis is open)" : "; an operator may be missing before it"));
      if (now().kind == Token::Kind::mark) next();
      if (now().kind != Token::Kind::end) sum();
    }
    return std::move(code_);
  }

 private:
  const Token& now() const { return tokens_[at_]; }
  void next() {
    if (now().kind != Token::Kind::end) ++at_;
  }
  bool isMark(const char* mark) const { return now().kind == Token::Kind::mark && now().text == mark; }
  void fault(const Token& token, const std::string& rule) { faults_.push_back({token.line, token.column, rule}); }
  void emit(Op op, int change, int index = 0, double value = 0.0) {
    code_.push_back({op, index, value});
    depth_ += change;
    if (depth_ > Expression::most_depth && !too_deep_) {
      too_deep_ = true;
      fault(now(), "the formula needs more than " + std::to_string(Expression::most_depth) + " values at a time");
    }
  }

  void sum() {
    product();
    while (isMark("+") || isMark("-")) {
      const Op op = isMark("+") ? Op::add : Op::subtract;
      next();
      product();
      emit(op, -1);
    }
  }
  void product() {
    sign();
    while (isMark("*") || isMark("/")) {
      const Op op = isMark("*") ? Op::multiply : Op::divide;
      next();
      sign();
      emit(op, -1);
    }
  }
  void sign() {
    bool negative = false;
    while (isMark("+") || isMark("-")) {
      negative = negative != isMark("-");
      next();
    }
    power();
    if (negative) emit(Op::negate, 0);
  }
  void power() {
    const std::size_t base = code_.size();
    primary();
    if (!isMark("^")) return;
    next();
    const std::size_t from = code_.size();
    if (++nesting_ > most_nesting) {
      tooNested();
      --nesting_;
      return;
    }
    sign();
    --nesting_;
    double exponent;
    if (isConstant(from, exponent) && std::abs(exponent) <= largest_whole_power && exponent == static_cast<int>(exponent)) {
      code_.resize(from);
      --depth_;
      if (from == base + 1 && code_[base].op == Op::constant)
        code_[base].value = wholePower(code_[base].value, static_cast<int>(exponent));
      else
        emit(Op::whole_power, 0, static_cast<int>(exponent));
    } else {
      emit(Op::power, -1);
    }
  }
  /// Whether the code from a place on is a number, perhaps with a sign.
  bool isConstant(std::size_t from, double& value) const {
    const std::size_t n = code_.size() - from;
    if (n == 0 || n > 2 || code_[from].op != Op::constant) return false;
    if (n == 2 && code_[from + 1].op != Op::negate) return false;
    value = n == 2 ? -code_[from].value : code_[from].value;
    return true;
  }
  void primary() {
    const Token token = now();
    if (token.kind == Token::Kind::number) {
      next();
      emit(Op::constant, 1, 0, token.value);
    } else if (token.kind == Token::Kind::name) {
      next();
      isMark("(") ? call(token) : name(token);
    } else if (isMark("(")) {
      next();
      inside(token);
    } else {
      fault(token, token.kind == Token::Kind::end ? "a value is missing at the end"
                                                  : "a value is missing before '" + token.text + "'");
      emit(Op::constant, 1);
    }
  }
  void tooNested() {
    too_nested_ = true;
    fault(now(), "parentheses and powers are nested more than " + std::to_string(most_nesting) + " deep");
    while (now().kind != Token::Kind::end) next();
    emit(Op::constant, 1);
  }
  void inside(const Token& open) {
    if (++nesting_ > most_nesting) {
      tooNested();
    } else {
      sum();
      close(open);
    }
    --nesting_;
  }
  void close(const Token& open) {
    if (too_nested_) return;
    if (isMark(")")) next();
    else if (now().kind == Token::Kind::end) fault(open, "this parenthesis is not closed");
    else {
      fault(now(), "')' or an operator is expected instead of '" + now().text + "'");
      int level = 1;
      for (; now().kind != Token::Kind::end && level > 0; next()) level += isMark("(") ? 1 : isMark(")") ? -1 : 0;
    }
  }
  void name(const Token& token) {
    const auto found = std::find(names_.begin(), names_.end(), token.text);
    if (found != names_.end()) {
      emit(Op::variable, 1, static_cast<int>(found - names_.begin()));
    } else if (token.text == "pi") {
      emit(Op::constant, 1, 0, pi);
    } else {
      fault(token, functionOf(token.text) != nullptr
                       ? "the function '" + token.text + "' needs its arguments in parentheses"
                       : "'" + token.text + "' is not known here; nearest: " + nearestWord(token.text, names_));
      if (functionOf(token.text) != nullptr && (now().kind == Token::Kind::name || now().kind == Token::Kind::number)) next();
      emit(Op::constant, 1);
    }
  }
  void call(const Token& token) {
    const Function* function = functionOf(token.text);
    if (function == nullptr) {
      const bool value = std::find(names_.begin(), names_.end(), token.text) != names_.end();
      fault(token, value ? "'" + token.text + "' is a value, not a function; an operator may be missing behind it"
                         : "there is no function '" + token.text + "'; nearest: " +
                               nearestWord(token.text, formulaFunctions()));
    }
    const Token open = now();
    next();
    if (++nesting_ > most_nesting) {
      tooNested();
      --nesting_;
      return;
    }
    int count = 0;
    if (!isMark(")")) {
      sum();
      ++count;
      while (isMark(",")) {
        next();
        sum();
        ++count;
      }
    }
    close(open);
    --nesting_;
    if (function != nullptr && count != function->arguments) {
      fault(token, "'" + token.text + "' has " + std::to_string(count) + " arguments; it takes " +
                       std::to_string(function->arguments));
    }
    if (function != nullptr && count == function->arguments) {
      emit(function->op, 1 - count);
    } else {  // goes on with one value in its place
      for (; count > 1; --count) emit(Op::add, -1);
      if (count == 0) emit(Op::constant, 1);
    }
  }

  std::vector<Token> tokens_;
  const std::vector<std::string>& names_;
  std::vector<FormulaFault>& faults_;
  std::vector<Expression::Instruction> code_;
  std::size_t at_ = 0;
  int depth_ = 0, nesting_ = 0;
  bool too_deep_ = false, too_nested_ = false;
};

}  // namespace

const std::vector<std::string>& formulaFunctions() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Function& function : functions) all.push_back(function.name);
    return all;
  }();
  return names;
}

Expression Expression::compile(const std::string& text, const std::vector<std::string>& names,
                               std::vector<FormulaFault>& faults) {
  Expression out;
  std::vector<FormulaFault> own;
  if (text.size() > most_characters) {
    own.push_back({1, 1, "the formula is longer than " + std::to_string(most_characters) + " characters"});
  } else {
    Parser parser(tokensOf(text, own), names, own);
    out.code_ = parser.parse();
  }
  if (!own.empty()) out.code_ = {{Op::constant, 0, 0.0}};
  std::stable_sort(own.begin(), own.end(), [](const FormulaFault& a, const FormulaFault& b) {
    return a.line != b.line ? a.line < b.line : a.column < b.column;
  });
  faults.insert(faults.end(), own.begin(), own.end());
  return out;
}

bool Expression::reads(int variable) const {
  return std::any_of(code_.begin(), code_.end(), [&](const Instruction& step) {
    return step.op == Op::variable && step.index == variable;
  });
}

}  // namespace amb_rotor
