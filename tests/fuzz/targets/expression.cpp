// Functions of implicit surfaces, as text: parsed, compiled and multiplied out.
#include "expression/polynomial.h"
#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

bool accepts_expression(std::string_view bytes) {
  const auto parsed = expression::parse(bytes);
  if (!parsed.ok()) {
    require(std::string(parsed.status().message()).starts_with("column "), "an error without a column");
    return false;
  }
  require(parsed->nodes.size() <= expression::kMaxOperations, "more operations than the limit");
  for (std::size_t i = 0; i < parsed->nodes.size(); ++i) {
    for (const std::int32_t from : parsed->nodes[i].from)
      require(from < static_cast<std::int32_t>(i), "an operand behind its operation");
  }
  if (const auto polynomial = expression::expand(*parsed)) {
    require(polynomial->degree <= expression::kMaxDegree, "a degree above the limit");
    require(polynomial->coefficients.size() == expression::Polynomial::index_of(0, 0, polynomial->degree) + 1,
            "another number of coefficients");
  }
  const auto program = expression::compile(*parsed);
  if (!program.ok()) return true;  // too many values at once
  require(!program->instructions.empty(), "an empty program");
  require(program->registers <= expression::kMaxRegisters, "more registers than the limit");
  for (const expression::Instruction& i : program->instructions) {
    require(i.target >= 3 && i.target < program->registers, "a target that is no register");
    for (const std::uint8_t from : i.from)
      require(from < program->registers, "an operand that is no register");
  }
  return true;
}

}  // namespace

const Target kExpression = {"expression", accepts_expression};

}  // namespace tessera::fuzz
