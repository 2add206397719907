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

  /// Replaces every $name by its value (the longest name that fits) and every \$ by $. The name of a
  /// parameter that does not exist, or nothing.
  std::string substitute(std::string& text);

  /// Names from the command line that no file has a <default> for or uses.
  std::vector<std::string> unused() const;

 private:
  struct Entry {
    std::string value;
    bool used = false;
  };
  std::map<std::string, Entry> entries_;
};

}  // namespace tessera::client::mitsuba
