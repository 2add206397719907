#include "expression/polynomial.h"

namespace tessera::expression {

namespace {

std::size_t count_of(int degree) { return Polynomial::index_of(0, 0, degree) + 1; }

Polynomial of_degree(int degree) { return {degree, std::vector<double>(count_of(degree), 0.0)}; }

Polynomial constant(double value) { return {0, {value}}; }

Polynomial monomial(int axis) {
  Polynomial p = of_degree(1);
  p.coefficients[static_cast<std::size_t>(1 + axis)] = 1;
  return p;
}

Polynomial sum(const Polynomial& a, const Polynomial& b, double sign) {
  Polynomial result = a.degree >= b.degree ? a : of_degree(b.degree);
  if (a.degree < b.degree) {
    for (std::size_t i = 0; i < a.coefficients.size(); ++i) result.coefficients[i] = a.coefficients[i];
  }
  for (std::size_t i = 0; i < b.coefficients.size(); ++i) result.coefficients[i] += sign * b.coefficients[i];
  return result;
}

template <class F>
void for_each_term(const Polynomial& p, F&& f) {
  for (int i = 0; i <= p.degree; ++i) {
    for (int j = 0; i + j <= p.degree; ++j) {
      for (int k = 0; i + j + k <= p.degree; ++k) {
        if (const double c = p.at(i, j, k); c != 0) f(i, j, k, c);
      }
    }
  }
}

std::optional<Polynomial> product(const Polynomial& a, const Polynomial& b) {
  if (a.degree + b.degree > kMaxDegree) return std::nullopt;
  Polynomial result = of_degree(a.degree + b.degree);
  for_each_term(a, [&](int i, int j, int k, double c) {
    for_each_term(b, [&](int l, int m, int n, double d) {
      result.coefficients[Polynomial::index_of(i + l, j + m, k + n)] += c * d;
    });
  });
  return result;
}

std::optional<Polynomial> power(const Polynomial& base, int exponent) {
  if (exponent < 0 || exponent * base.degree > kMaxDegree) return std::nullopt;
  std::optional<Polynomial> result = constant(1);
  for (int i = 0; i < exponent && result; ++i) result = product(*result, base);
  return result;
}

std::optional<Polynomial> combine(const Node& node, const std::vector<std::optional<Polynomial>>& done) {
  const auto from = [&](int i) -> const std::optional<Polynomial>& {
    return done[static_cast<std::size_t>(node.from[i])];
  };
  for (int i = 0; i < 3; ++i) {
    if (node.from[i] >= 0 && !from(i)) return std::nullopt;
  }
  switch (node.op) {
    case Op::kX:
    case Op::kY:
    case Op::kZ:
      return monomial(static_cast<int>(node.op) - static_cast<int>(Op::kX));
    case Op::kConstant:
      return constant(node.value);
    case Op::kAdd:
      return sum(*from(0), *from(1), 1);
    case Op::kSubtract:
      return sum(*from(0), *from(1), -1);
    case Op::kNegate:
      return sum(constant(0), *from(0), -1);
    case Op::kMultiply:
      return product(*from(0), *from(1));
    case Op::kDivide: {
      if (from(1)->degree > 0) return std::nullopt;
      Polynomial result = *from(0);
      for (double& c : result.coefficients) c /= from(1)->coefficients[0];
      return result;
    }
    case Op::kPower:
      return power(*from(0), node.power);
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<Polynomial> expand(const Expression& expression) {
  std::vector<std::optional<Polynomial>> done;
  done.reserve(expression.nodes.size());
  for (const Node& node : expression.nodes) done.push_back(combine(node, done));
  std::optional<Polynomial> result = std::move(done[static_cast<std::size_t>(expression.root)]);
  // Leading terms may have cancelled.
  while (result && result->degree > 0) {
    const std::size_t lower = count_of(result->degree - 1);
    bool zero = true;
    for (std::size_t i = lower; i < result->coefficients.size(); ++i)
      zero = zero && result->coefficients[i] == 0;
    if (!zero) break;
    result->coefficients.resize(lower);
    --result->degree;
  }
  return result;
}

}  // namespace tessera::expression
