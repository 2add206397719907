#include "expression/expression.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::expression {

namespace {

struct Function {
  std::string_view name;
  Op op;
  int least, most;  // arguments
};
constexpr int kAnyNumber = 1 << 20;
constexpr Function kFunctions[] = {{"sqrt", Op::kSqrt, 1, 1},        {"sin", Op::kSin, 1, 1},
                                   {"cos", Op::kCos, 1, 1},          {"exp", Op::kExp, 1, 1},
                                   {"log", Op::kLog, 1, 1},          {"abs", Op::kAbs, 1, 1},
                                   {"pow", Op::kPow, 2, 2},          {"min", Op::kMin, 2, kAnyNumber},
                                   {"max", Op::kMax, 2, kAnyNumber}, {"noise", Op::kNoise, 3, 3}};

constexpr double kLeastLog = 1e-300;

/// The value of an operation on constants; noise is left to the program.
std::optional<double> fold(const Node& node, double a, double b) {
  switch (node.op) {
    case Op::kAdd:
      return a + b;
    case Op::kSubtract:
      return a - b;
    case Op::kMultiply:
      return a * b;
    case Op::kDivide:
      return a / b;
    case Op::kNegate:
      return -a;
    case Op::kPower:
      return std::pow(a, node.power);
    case Op::kPow:
      return a > 0 ? std::pow(a, b) : 0;
    case Op::kSqrt:
      return std::sqrt(std::max(a, 0.0));
    case Op::kSin:
      return std::sin(a);
    case Op::kCos:
      return std::cos(a);
    case Op::kExp:
      return std::exp(a);
    case Op::kLog:
      return std::log(std::max(a, kLeastLog));
    case Op::kAbs:
      return std::abs(a);
    case Op::kMin:
      return std::min(a, b);
    case Op::kMax:
      return std::max(a, b);
    default:
      return std::nullopt;
  }
}

struct NodeHash {
  std::size_t operator()(const Node& node) const {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &node.value, sizeof(bits));
    for (const std::int64_t part :
         {std::int64_t{node.from[0]}, std::int64_t{node.from[1]}, std::int64_t{node.from[2]},
          std::int64_t{node.power}, static_cast<std::int64_t>(node.op)})
      bits = (bits ^ static_cast<std::uint64_t>(part)) * 0x9e3779b97f4a7c15u, bits ^= bits >> 29;
    return static_cast<std::size_t>(bits);
  }
};

/// Each rule returns the node that it read, or kNone after an error.
class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  absl::StatusOr<Expression> parse() {
    if (text_.size() > kMaxCharacters) {
      position_ = kMaxCharacters;
      fail(absl::StrCat("more than ", kMaxCharacters, " characters"));
    } else {
      expression_.root = equation();
    }
    if (error_) return absl::InvalidArgumentError(absl::StrCat("column ", error_column_, ": ", *error_));
    return std::move(expression_);
  }

 private:
  static constexpr std::int32_t kNone = -1;

  std::int32_t fail(std::string what) {
    if (!error_) error_ = std::move(what), error_column_ = position_ + 1;
    return kNone;
  }
  /// 0 at the end.
  char peek() {
    while (position_ < text_.size() && std::strchr(" \t\r\n", text_[position_]) != nullptr &&
           text_[position_] != '\0')
      ++position_;
    return position_ < text_.size() ? text_[position_] : '\0';
  }
  bool at_end() { return peek() == '\0' && position_ == text_.size(); }
  bool take(char c) {
    if (peek() != c || position_ == text_.size()) return false;
    ++position_;
    return true;
  }
  std::int32_t unexpected(const char* expected) {
    if (at_end()) return fail(absl::StrCat("the expression ends where ", expected, " was expected"));
    const char c = text_[position_];
    const std::string shown =
        c >= ' ' && c <= '~' ? absl::StrCat("'", std::string(1, c), "'") : "this character";
    return fail(absl::StrCat(shown, " is unknown here; ", expected, " was expected"));
  }

  /// The node of an operation: an earlier one where there is the same, a constant where all operands are.
  std::int32_t add(Node node) {
    double value[3] = {};
    bool constant = node.op != Op::kConstant && node.from[0] >= 0;
    for (int i = 0; i < 3 && node.from[i] >= 0; ++i) {
      const Node& from = expression_.nodes[static_cast<std::size_t>(node.from[i])];
      constant = constant && from.op == Op::kConstant;
      value[i] = from.value;
    }
    if (constant) {
      if (const std::optional<double> folded = fold(node, value[0], value[1])) {
        if (!std::isfinite(*folded)) return fail("a constant here is not finite");
        node = {.value = *folded};
      }
    }
    if (const auto known = known_.find(node); known != known_.end()) return known->second;
    if (expression_.nodes.size() == kMaxOperations)
      return fail(absl::StrCat("more than ", kMaxOperations, " operations"));
    const auto index = static_cast<std::int32_t>(expression_.nodes.size());
    expression_.nodes.push_back(node);
    known_.emplace(node, index);
    return index;
  }
  std::int32_t operation(Op op, std::int32_t a, std::int32_t b = kNone, std::int32_t c = kNone) {
    return add({.op = op, .from = {a, b, c}});
  }

  std::int32_t equation() {
    std::int32_t left = sum();
    if (left == kNone) return kNone;
    if (take('=')) {
      const std::int32_t right = sum();
      if (right == kNone) return kNone;
      left = operation(Op::kSubtract, left, right);
    }
    return left == kNone || at_end() ? left : unexpected("an operator or the end");
  }

  std::int32_t sum() {
    std::int32_t left = product();
    while (left != kNone) {
      const bool plus = take('+');
      if (!plus && !take('-')) break;
      const std::int32_t right = product();
      left = right == kNone ? kNone : operation(plus ? Op::kAdd : Op::kSubtract, left, right);
    }
    return left;
  }

  std::int32_t product() {
    std::int32_t left = factor();
    while (left != kNone) {
      const bool times = take('*');
      if (!times && !take('/')) break;
      const std::int32_t right = factor();
      left = right == kNone ? kNone : operation(times ? Op::kMultiply : Op::kDivide, left, right);
    }
    return left;
  }

  std::int32_t factor() {
    if (++depth_ > kMaxNesting) return fail(absl::StrCat("nested more than ", kMaxNesting, " deep"));
    std::int32_t node = kNone;
    if (take('-')) {
      node = factor();
      if (node != kNone) node = operation(Op::kNegate, node);
    } else if (take('+')) {
      node = factor();
    } else {
      node = atom();
      if (node != kNone && take('^')) {
        const std::int32_t exponent = factor();
        node = exponent == kNone ? kNone : raise(node, exponent);
      }
    }
    --depth_;
    return node;
  }

  std::int32_t raise(std::int32_t base, std::int32_t exponent) {
    const Node& power = expression_.nodes[static_cast<std::size_t>(exponent)];
    if (power.op != Op::kConstant || power.value != std::trunc(power.value))
      return operation(Op::kPow, base, exponent);
    if (std::abs(power.value) > kMaxExponent)
      return fail(absl::StrCat("a whole exponent beyond ", kMaxExponent));
    const auto n = static_cast<std::int32_t>(power.value);
    return n == 1 ? base : add({.op = Op::kPower, .from = {base, kNone, kNone}, .power = n});
  }

  std::int32_t atom() {
    const char c = peek();
    if (take('(')) {
      const std::int32_t node = sum();
      return node == kNone || take(')') ? node : unexpected("an operator or ')'");
    }
    if ((c >= '0' && c <= '9') || c == '.') return number();
    const std::size_t begin = position_;
    while (position_ < text_.size() && text_[position_] >= 'a' && text_[position_] <= 'z') ++position_;
    const std::string_view name = text_.substr(begin, position_ - begin);
    if (name.empty()) return unexpected("a number, x, y, z, a function or '('");
    if (name.size() == 1 && name[0] >= 'x')
      return add({.op = static_cast<Op>(static_cast<int>(Op::kX) + (name[0] - 'x'))});
    if (name == "pi") return add({.value = std::numbers::pi});
    for (const Function& function : kFunctions) {
      if (function.name == name) return call(function);
    }
    position_ = begin;
    return fail(absl::StrCat("'", std::string(name.substr(0, 32)),
                             "' is unknown; x, y, z, pi, sqrt, sin, cos, exp, log, abs, min, max, pow and "
                             "noise are known"));
  }

  std::int32_t number() {
    double value = 0;
    const auto [end, error] = std::from_chars(text_.data() + position_, text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return fail("a number that is finite was expected");
    position_ = static_cast<std::size_t>(end - text_.data());
    return add({.value = value});
  }

  std::int32_t call(const Function& function) {
    if (!take('(')) return unexpected("'('");
    std::int32_t arguments[3] = {kNone, kNone, kNone};
    int count = 0;
    do {
      const std::int32_t argument = sum();
      if (argument == kNone) return kNone;
      if (++count > function.most) return wrong_count(function);
      if (count > 2 && function.most == kAnyNumber) {  // min(a, b, c) is min(min(a, b), c)
        arguments[0] = operation(function.op, arguments[0], arguments[1]);
        if (arguments[0] == kNone) return kNone;
        arguments[1] = argument;
      } else {
        arguments[count - 1] = argument;
      }
    } while (take(','));
    if (!take(')')) return unexpected("an operator, ',' or ')'");
    if (count < function.least) return wrong_count(function);
    return function.op == Op::kPow ? raise(arguments[0], arguments[1])
                                   : operation(function.op, arguments[0], arguments[1], arguments[2]);
  }
  std::int32_t wrong_count(const Function& function) {
    return fail(absl::StrCat(std::string(function.name), " takes ", function.least,
                             function.most > function.least ? " arguments or more"
                             : function.least == 1          ? " argument"
                                                            : " arguments"));
  }

  const std::string_view text_;
  std::size_t position_ = 0;
  int depth_ = 0;
  Expression expression_;
  std::unordered_map<Node, std::int32_t, NodeHash> known_;
  std::optional<std::string> error_;
  std::size_t error_column_ = 0;
};

}  // namespace

absl::StatusOr<Expression> parse(std::string_view text) { return Parser(text).parse(); }

}  // namespace tessera::expression
