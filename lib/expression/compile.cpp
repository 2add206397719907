#include <array>
#include <limits>

#include "absl/strings/str_cat.h"
#include "expression/expression.h"

namespace tessera::expression {

namespace {

/// Registers that nobody needs.
class FreeRegisters {
 public:
  explicit FreeRegisters(int first) : most_(first) {
    for (int i = kMaxRegisters; i-- > first;) free_[static_cast<std::size_t>(count_++)] = i;
  }
  /// -1 where there is none left.
  int take() {
    if (count_ == 0) return -1;
    const int i = free_[static_cast<std::size_t>(--count_)];
    if (i >= most_) most_ = i + 1;
    return i;
  }
  void give(int i) { free_[static_cast<std::size_t>(count_++)] = i; }
  int most() const { return most_; }

 private:
  std::array<int, kMaxRegisters> free_{};
  int count_ = 0;
  int most_;
};

/// The last operation that each node is an operand of; -1 for those that the root does not need.
std::vector<std::int32_t> last_uses(const Expression& expression) {
  std::vector<std::int32_t> last(expression.nodes.size(), -1);
  last[static_cast<std::size_t>(expression.root)] = std::numeric_limits<std::int32_t>::max();
  for (std::int32_t i = expression.root; i >= 0; --i) {
    if (last[static_cast<std::size_t>(i)] < 0) continue;
    for (const std::int32_t from : expression.nodes[static_cast<std::size_t>(i)].from) {
      if (from >= 0 && last[static_cast<std::size_t>(from)] < i) last[static_cast<std::size_t>(from)] = i;
    }
  }
  return last;
}

}  // namespace

absl::StatusOr<Program> compile(const Expression& expression) {
  const std::vector<std::int32_t> last = last_uses(expression);
  std::vector<int> place(expression.nodes.size(), -1);
  FreeRegisters free(3);
  Program program;
  const auto emit = [&](const Node& node, const std::array<int, 3>& from) {
    const int target = free.take();
    if (target >= 0) {
      Instruction instruction{node.op, static_cast<std::uint8_t>(target), {}, node.power, node.value};
      for (std::size_t k = 0; k < 3; ++k)
        instruction.from[k] = static_cast<std::uint8_t>(from[k] < 0 ? 0 : from[k]);
      program.instructions.push_back(instruction);
    }
    return target;
  };
  const auto too_many = [] {
    return absl::InvalidArgumentError(
        absl::StrCat("the expression needs more than ", kMaxRegisters, " values at once"));
  };
  for (std::int32_t i = 0; i <= expression.root; ++i) {
    const Node& node = expression.nodes[static_cast<std::size_t>(i)];
    if (last[static_cast<std::size_t>(i)] < 0) continue;
    if (node.op <= Op::kZ && i != expression.root) {
      place[static_cast<std::size_t>(i)] = static_cast<int>(node.op);
      continue;
    }
    // A constant is loaded for each that uses it: kept, it would take a register for long.
    if (node.op == Op::kConstant && i != expression.root) continue;
    std::array<int, 3> from{-1, -1, -1};
    std::vector<int> done;  // registers free after this node
    if (node.op <= Op::kZ) from[0] = static_cast<int>(node.op);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t operand = node.from[k];
      if (operand < 0) continue;
      const Node& other = expression.nodes[static_cast<std::size_t>(operand)];
      bool again = false;
      for (std::size_t l = 0; l < k; ++l) {
        if (node.from[l] == operand) from[k] = from[l], again = true;
      }
      if (again) continue;
      if (other.op == Op::kConstant) {
        if ((from[k] = emit(other, {-1, -1, -1})) < 0) return too_many();
        done.push_back(from[k]);
        continue;
      }
      from[k] = place[static_cast<std::size_t>(operand)];
      if (last[static_cast<std::size_t>(operand)] == i && from[k] >= 3) done.push_back(from[k]);
    }
    const int target = emit(node, from);
    if (target < 0) return too_many();
    place[static_cast<std::size_t>(i)] = target;
    for (const int r : done) free.give(r);
  }
  program.registers = free.most();
  return program;
}

}  // namespace tessera::expression
