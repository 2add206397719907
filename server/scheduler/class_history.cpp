#include "scheduler/class_history.h"

#include <functional>
#include <set>
#include <string_view>

#include "wire/arithmetic_class.h"

namespace tessera::server {

std::vector<std::string> ClassHistory::all() const {
  std::vector<std::string> classes;
  if (!bound_.empty()) classes.push_back(bound_);
  for (const std::string& name : noted_) {
    if (name != bound_) classes.push_back(name);
  }
  return classes;
}

std::string isas_of(const std::vector<std::string>& classes) {
  std::set<std::string_view, std::greater<>> isas;
  for (const std::string& name : classes) isas.insert(wire::isa_of(name));
  std::string text;
  for (const std::string_view isa : isas) text += (text.empty() ? "" : "+") + std::string(isa);
  return text;
}

}  // namespace tessera::server
