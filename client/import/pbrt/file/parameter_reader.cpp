// The part of DirectiveReader that reads parameter lists.
#include <cmath>
#include <span>

#include "import/pbrt/file/directive_reader.h"

#include "import/input/concat.h"
#include "wire/scene_numbers.h"

namespace tessera::client::pbrt {

std::vector<Parameter> DirectiveReader::read_parameters() {
  std::vector<Parameter> parameters;
  while (peek().kind == TokenKind::kString && !context_.diagnostics.full()) {
    Parameter parameter;
    const bool declared = read_declaration(take(), parameter);
    read_values(parameter);
    if (!declared) continue;
    check_values(parameter);
    for (const Parameter& other : parameters) {
      if (other.name == parameter.name) {
        context_.diagnostics.error(parameter.where,
                                   concat("parameter \"", parameter.name, "\" is given twice"));
      }
    }
    parameters.push_back(std::move(parameter));
  }
  return parameters;
}

bool DirectiveReader::read_declaration(const Token& token, Parameter& parameter) {
  parameter.where = token.where;
  parameter.color_space = builder_.color_space();
  constexpr std::string_view kSpace = " \t";
  const std::string_view text = token.text;
  const std::size_t type_begin = text.find_first_not_of(kSpace);
  const std::size_t type_end =
      type_begin == std::string_view::npos ? type_begin : text.find_first_of(kSpace, type_begin);
  const std::size_t name_begin =
      type_end == std::string_view::npos ? type_end : text.find_first_not_of(kSpace, type_end);
  if (name_begin == std::string_view::npos) {
    context_.diagnostics.error(token.where,
                               concat("expected a parameter as in \"float radius\", found \"", text, "\""));
    return false;
  }
  const std::size_t name_end = std::min(text.find_first_of(kSpace, name_begin), text.size());
  const std::string_view type = text.substr(type_begin, type_end - type_begin);
  parameter.name = text.substr(name_begin, name_end - name_begin);
  const std::optional<ParameterType> known = parameter_type_of(type);
  if (!known) {
    context_.diagnostics.error(token.where,
                               concat("unknown parameter type \"", type,
                                      "\": expected integer, float, point2, vector2, point3, vector3, ",
                                      "normal, spectrum, rgb, blackbody, bool, string or texture"));
    return false;
  }
  parameter.type = *known;
  return true;
}

void DirectiveReader::read_values(Parameter& parameter) {
  if (peek().kind != TokenKind::kOpen) {
    const Token token = peek();
    const bool is_value = token.kind == TokenKind::kString || token.kind == TokenKind::kWord;
    if (!is_value || (token.kind == TokenKind::kWord && find_syntax(token.text) != nullptr)) {
      fail(token, concat("the value of \"", parameter.name, "\""));
      return;
    }
    read_value(take(), parameter);
    return;
  }
  take();
  const bool numeric = numbers_per_value(parameter.type) > 0;
  while (true) {
    // Long arrays go the fast way; whatever is not a plain number comes one by one.
    if (numeric && !has_lookahead_) {
      tokenizer_->read_numbers([&](double value) { parameter.numbers.push_back(value); });
    }
    const Token token = peek();
    if (token.kind == TokenKind::kClose) {
      take();
      return;
    }
    const bool is_value = token.kind == TokenKind::kString || token.kind == TokenKind::kWord;
    if (!is_value || (token.kind == TokenKind::kWord && find_syntax(token.text) != nullptr)) {
      fail(token, concat("\"]\" after the values of \"", parameter.name, "\""));
      return;
    }
    if (!read_value(take(), parameter)) break;
  }
  // One error for an array is enough.
  while (peek().kind == TokenKind::kString ||
         (peek().kind == TokenKind::kWord && find_syntax(peek().text) == nullptr))
    take();
  if (peek().kind == TokenKind::kClose) take();
}

bool DirectiveReader::read_value(const Token& token, Parameter& parameter) {
  const bool is_string = token.kind == TokenKind::kString;
  if (parameter.type == ParameterType::kBool) {
    if (token.text == "true" || token.text == "false") {
      parameter.numbers.push_back(token.text == "true" ? 1 : 0);
      return true;
    }
    fail(token, "true or false");
    return false;
  }
  const bool takes_strings = parameter.type == ParameterType::kString ||
                             parameter.type == ParameterType::kTexture ||
                             parameter.type == ParameterType::kSpectrum;
  if (is_string && takes_strings) {
    std::optional<std::string> text = unescape(token.text);
    if (!text) {
      fail(token, "a string without unknown escapes");
      return false;
    }
    parameter.strings.push_back(*std::move(text));
    return true;
  }
  if (numbers_per_value(parameter.type) == 0) {
    fail(token, concat("a string for \"", parameter.name, "\""));
    return false;
  }
  if (!is_string) {
    if (const std::optional<double> number = parse_number(token.text)) {
      parameter.numbers.push_back(*number);
      return true;
    }
  }
  fail(token, concat(wire::kSceneNumberRange, " for \"", parameter.name, "\""));
  return false;
}

void DirectiveReader::check_values(Parameter& parameter) {
  const int group = numbers_per_value(parameter.type);
  if (group > 0 && parameter.type != ParameterType::kSpectrum && parameter.numbers.size() % group != 0) {
    context_.diagnostics.error(
        parameter.where, concat("parameter \"", parameter.name, "\": ", name_of(parameter.type), " takes ",
                                group, " numbers a value, found ", parameter.numbers.size()));
    parameter.numbers.resize(parameter.numbers.size() / group * group);
  }
  if (parameter.type != ParameterType::kInteger) return;
  for (const double value : parameter.numbers) {
    if (value != std::floor(value) || std::abs(value) > 2147483648.0) {
      context_.diagnostics.error(parameter.where, concat("parameter \"", parameter.name,
                                                         "\": expected 32-bit integers, found ", value));
      return;
    }
  }
}

}  // namespace tessera::client::pbrt
