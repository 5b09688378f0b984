#pragma once
// Formulas that people write into effect files, compiled to a flat program for a Scalar. Nothing of them is ever run as
// code: the program knows the operations below and the names that it is given, no more.
//
//   sum     = product { (+ | -) product }
//   product = sign { (* | /) sign }
//   sign    = { + | - } power
//   power   = primary [ ^ sign ]             binds tighter than a sign before it: -x^2 = -(x^2); 2^3^2 = 2^9
//   primary = number | name | function ( sum { , sum } ) | ( sum )
//
// Functions: sin cos tan atan sqrt exp log tanh abs sign step of one argument; min max hypot atan2 of two.
// sign(0) = 0; step(a) = 1 where a > 0, else 0. Constant: pi. a^n with a whole number n up to 16 written out is a product;
// any other power is exp(b log a): 0 where a is 0, not a number where a is below 0. Angles in rad.
#include <string>
#include <vector>

#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

/// What is wrong in a formula, and where in its text; both from 1.
struct FormulaFault {
  int line = 1, column = 1;
  std::string rule;
};

class Expression {
 public:
  enum class Op {
    constant, variable, add, subtract, multiply, divide, negate, whole_power, power,
    sine, cosine, tangent, arc_tangent, square_root, exponential, logarithm, hyperbolic_tangent, magnitude, sign, step,
    minimum, maximum, hypotenuse, arc_tangent_2
  };
  struct Instruction {
    Op op;
    int index;     ///< of the variable; the exponent of a whole power
    double value;  ///< of the constant
  };
  static constexpr int most_depth = 32;  ///< of the stack

  /// Compiles a formula over the names; a variable's index is its place there. All faults at once are added to the list;
  /// where there is one the result is the constant 0.
  static Expression compile(const std::string& text, const std::vector<std::string>& names,
                            std::vector<FormulaFault>& faults);

  /// Whether the formula reads a variable.
  bool reads(int variable) const;
  const std::vector<Instruction>& code() const { return code_; }

  /// The value, from one value a name.
  template <class S>
  S evaluate(const S* variables) const;

 private:
  std::vector<Instruction> code_;
};

/// The functions' names, in the order of the list above.
const std::vector<std::string>& formulaFunctions();

template <class S>
S wholePower(const S& a, int exponent) {
  const int n = exponent < 0 ? -exponent : exponent;
  S result(1.0), square = a;
  for (int bits = n; bits > 0; bits >>= 1) {
    if (bits & 1) result = result * square;
    square = square * square;
  }
  return exponent < 0 ? S(1.0) / result : result;
}

template <class S>
S anyPower(const S& a, const S& b) {
  const S zero(0.0);
  const S safe = select(a > zero, a, S(1.0));
  const S value = exponential(b * logarithm(safe));
  // 0^0 is 1, as for a whole power
  const S at_zero = select(b == zero, S(1.0), zero);
  return select(a > zero, value, select(a == zero, at_zero, S(std::nan(""))));
}

template <class S>
S Expression::evaluate(const S* variables) const {
  S stack[most_depth];
  int top = -1;
  for (const Instruction& step : code_) {
    S& a = stack[top < 0 ? 0 : top];              // of one argument: it; of two: the second
    S& first = stack[top < 1 ? 0 : top - 1];      // of two
    switch (step.op) {
      case Op::constant: stack[++top] = S(step.value); break;
      case Op::variable: stack[++top] = variables[step.index]; break;
      case Op::add: first = first + a; --top; break;
      case Op::subtract: first = first - a; --top; break;
      case Op::multiply: first = first * a; --top; break;
      case Op::divide: first = first / a; --top; break;
      case Op::negate: a = -a; break;
      case Op::whole_power: a = wholePower(a, step.index); break;
      case Op::power: first = anyPower(first, a); --top; break;
      case Op::sine: {
        S sine, cosine;
        sineCosine(a, sine, cosine);
        a = sine;
        break;
      }
      case Op::cosine: {
        S sine, cosine;
        sineCosine(a, sine, cosine);
        a = cosine;
        break;
      }
      case Op::tangent: {
        S sine, cosine;
        sineCosine(a, sine, cosine);
        a = sine / cosine;
        break;
      }
      case Op::arc_tangent: a = arcTangent(a, S(1.0)); break;
      case Op::square_root: a = squareRoot(a); break;
      case Op::exponential: a = amb_rotor::exponential(a); break;
      case Op::logarithm: a = amb_rotor::logarithm(a); break;
      case Op::hyperbolic_tangent: a = hyperbolicTangent(a); break;
      case Op::magnitude: a = amb_rotor::magnitude(a); break;
      case Op::sign: a = select(a > S(0.0), S(1.0), select(a < S(0.0), S(-1.0), S(0.0))); break;
      case Op::step: a = select(a > S(0.0), S(1.0), S(0.0)); break;
      case Op::minimum: first = amb_rotor::minimum(first, a); --top; break;
      case Op::maximum: first = amb_rotor::maximum(first, a); --top; break;
      case Op::hypotenuse: first = squareRoot(first * first + a * a); --top; break;
      case Op::arc_tangent_2: first = arcTangent(first, a); --top; break;
    }
  }
  return top == 0 ? stack[0] : S(0.0);
}

}  // namespace amb_rotor
