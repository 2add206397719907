#include "command/query/row_text.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace tessera::client {
namespace {

template <class Number>
void append_number(Number x, std::string& text) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, x).ptr);
}

void append_csv_text(std::string_view value, std::string& text) {
  if (value.find_first_of(",\"\r\n") == value.npos) {
    text += value;
    return;
  }
  text += '"';
  for (const char c : value) text.append(c == '"' ? 2 : 1, c);
  text += '"';
}

bool has_value(const Cell& cell) {
  if (const double* x = std::get_if<double>(&cell)) return std::isfinite(*x);
  if (const float* x = std::get_if<float>(&cell)) return std::isfinite(*x);
  return !std::holds_alternative<std::monostate>(cell);
}

void append_cell(const Cell& cell, RowFormat format, std::string& text) {
  if (const auto* i = std::get_if<std::int64_t>(&cell)) append_number(*i, text);
  if (const auto* x = std::get_if<double>(&cell)) append_number(*x, text);
  if (const auto* x = std::get_if<float>(&cell)) append_number(*x, text);
  if (const auto* t = std::get_if<std::string_view>(&cell)) {
    if (format == RowFormat::kCsv) {
      append_csv_text(*t, text);
    } else {
      text += nlohmann::json(std::string(*t)).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }
  }
}

}  // namespace

void append_header(Columns columns, RowFormat format, std::string& text) {
  if (format != RowFormat::kCsv) return;
  for (const char* const name : columns) {
    if (name != columns.front()) text += ',';
    text += name;
  }
  text += '\n';
}

void append_row(Columns columns, const Row& row, RowFormat format, std::string& text) {
  const bool csv = format == RowFormat::kCsv;
  bool first = true;
  if (!csv) text += '{';
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const bool there = has_value(row[i]);
    if (csv) {
      if (i > 0) text += ',';
    } else if (there) {
      if (!first) text += ',';
      text.append("\"").append(columns[i]).append("\":");
      first = false;
    }
    if (there) append_cell(row[i], format, text);
  }
  text += csv ? "\n" : "}\n";
}

}  // namespace tessera::client
