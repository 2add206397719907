// $name in attributes: values from the command line and from <default>.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::client::mitsuba {

class Parameters {
 public:
  explicit Parameters(const std::map<std::string, std::string>& defines);

  /// A <default>: counts only where nothing has that name yet.
  void add_default(const std::string& name, const std::string& value);

  /// Characters that all values together may be put in place of names with: values are made of values, and
  /// may double with every line.
  static constexpr std::size_t kMostCharacters = std::size_t{1} << 26;

  /// Replaces every $name by its value (the longest name that fits) and every \$ by $. Returns what is wrong
  /// where a parameter does not exist, or the text becomes too long.
  std::string substitute(std::string& text);

  /// Names from the command line that no file has a <default> for or uses.
  std::vector<std::string> unused() const;

 private:
  struct Entry {
    std::string value;
    bool used = false;
  };
  std::map<std::string, Entry> entries_;
  std::size_t substituted_characters_ = 0;
};

}  // namespace tessera::client::mitsuba
