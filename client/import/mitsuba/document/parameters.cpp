#include "import/mitsuba/document/parameters.h"

#include <cctype>

#include "import/input/concat.h"

namespace tessera::client::mitsuba {
namespace {

bool is_name_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

}  // namespace

Parameters::Parameters(const std::map<std::string, std::string>& defines) {
  for (const auto& [name, value] : defines) entries_[name] = {value, false};
}

void Parameters::add_default(const std::string& name, const std::string& value) {
  const auto [entry, is_new] = entries_.try_emplace(name, Entry{value, true});
  if (!is_new) entry->second.used = true;
}

std::string Parameters::substitute(std::string& text) {
  if (text.find('$') == std::string::npos) return "";
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == '\\' && i + 1 < text.size() && text[i + 1] == '$') {
      result.push_back('$');
      i += 2;
      continue;
    }
    if (text[i] != '$') {
      result.push_back(text[i++]);
      continue;
    }
    const std::string_view rest = std::string_view(text).substr(i + 1);
    auto best = entries_.end();
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry) {
      const bool fits = !entry->first.empty() && rest.starts_with(entry->first);
      if (fits && (best == entries_.end() || entry->first.size() > best->first.size())) best = entry;
    }
    if (best == entries_.end()) {
      std::size_t end = 0;
      while (end < rest.size() && is_name_character(rest[end])) ++end;
      return concat("there is no parameter $", rest.substr(0, end),
                    ": expected a <default> or a definition for it");
    }
    substituted_characters_ += best->second.value.size();
    if (substituted_characters_ > kMostCharacters)
      return concat("the values of parameters come to more than ", kMostCharacters, " characters");
    result += best->second.value;
    best->second.used = true;
    i += 1 + best->first.size();
  }
  text = std::move(result);
  return "";
}

std::vector<std::string> Parameters::unused() const {
  std::vector<std::string> names;
  for (const auto& [name, entry] : entries_) {
    if (!entry.used) names.push_back(name);
  }
  return names;
}

}  // namespace tessera::client::mitsuba
