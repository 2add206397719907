#include "import/gltf/file/json_text.h"

#include <algorithm>
#include <set>
#include <vector>

#include "import/input/concat.h"

namespace tessera::client::gltf {
namespace {

/// "line:column" of a byte.
std::string line_and_column(std::string_view text, std::size_t at) {
  const std::string_view before = text.substr(0, std::min(at, text.size()));
  const std::size_t start = before.rfind('\n') + 1;
  return concat(std::count(before.begin(), before.end(), '\n') + 1, ":", before.size() - start + 1);
}

/// Builds the document while it is read, and stops where a bound is passed.
class Builder final : public Json::json_sax_t {
 public:
  Json root;
  std::string fault;
  std::size_t fault_at = 0;

  bool null() override { return add(Json(nullptr)) != nullptr; }
  bool boolean(bool value) override { return add(Json(value)) != nullptr; }
  bool number_integer(number_integer_t value) override { return add(Json(value)) != nullptr; }
  bool number_unsigned(number_unsigned_t value) override { return add(Json(value)) != nullptr; }
  bool number_float(number_float_t value, const string_t&) override { return add(Json(value)) != nullptr; }
  bool string(string_t& value) override { return add(Json(std::move(value))) != nullptr; }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    name_ = std::move(name);
    if (!open_.back()->contains(name_)) return true;
    fault = concat("the name \"", name_, "\" stands twice in one object");
    return false;
  }
  bool parse_error(std::size_t at, const std::string&, const nlohmann::detail::exception& what) override {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error ..."
    const std::string text = what.what();
    const std::size_t reason = text.find(": ");
    fault = reason == std::string::npos ? text : text.substr(reason + 2);
    fault_at = at == 0 ? 0 : at - 1;
    return false;
  }

 private:
  Json* add(Json value) {
    if (++count_ > kMostJsonValues) {
      fault = concat("more than ", kMostJsonValues, " values");
      return nullptr;
    }
    if (open_.empty()) return &(root = std::move(value));
    Json& parent = *open_.back();
    if (parent.is_array()) return &parent.emplace_back(std::move(value));
    return &(parent[name_] = std::move(value));
  }
  bool open(Json value) {
    if (open_.size() >= kMostJsonLevels) {
      fault = concat("more than ", kMostJsonLevels, " levels within one another");
      return false;
    }
    Json* const place = add(std::move(value));
    if (place == nullptr) return false;
    open_.push_back(place);
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  // Whoever is open is the last of its parent, which does not grow meanwhile: the pointers hold.
  std::vector<Json*> open_;
  std::string name_;
  std::size_t count_ = 0;
};

}  // namespace

absl::StatusOr<Json> parse_json(std::string_view text) {
  Builder builder;
  if (Json::sax_parse(text, &builder)) return std::move(builder.root);
  const std::string place = builder.fault_at > 0 ? line_and_column(text, builder.fault_at) : "1:1";
  return absl::InvalidArgumentError(concat(place, ": ", builder.fault.empty() ? "no JSON" : builder.fault));
}

std::string below(std::string_view place, std::string_view name) {
  std::string result = concat(std::string(place), "/");
  for (const char c : name) {
    if (c == '~') {
      result += "~0";
    } else if (c == '/') {
      result += "~1";
    } else {
      result += c;
    }
  }
  return result;
}

std::string below(std::string_view place, std::size_t index) {
  return concat(std::string(place), "/", index);
}

const Json* member(const Json* object, const char* name) {
  if (object == nullptr || !object->is_object()) return nullptr;
  const auto found = object->find(name);
  return found == object->end() ? nullptr : &*found;
}

double number_of(const Json* object, const char* name, double fallback) {
  const Json* value = member(object, name);
  return value == nullptr ? fallback : value->get<double>();
}

std::int64_t integer_of(const Json* object, const char* name, std::int64_t fallback) {
  const Json* value = member(object, name);
  // The schema bounds integers to what doubles hold exactly.
  return value == nullptr ? fallback : static_cast<std::int64_t>(value->get<double>());
}

std::size_t size_member(const Json& object, const char* name) {
  return static_cast<std::size_t>(integer_of(&object, name, 0));
}

bool flag_of(const Json* object, const char* name, bool fallback) {
  const Json* value = member(object, name);
  return value == nullptr ? fallback : value->get<bool>();
}

std::string text_of(const Json* object, const char* name, const std::string& fallback) {
  const Json* value = member(object, name);
  return value == nullptr ? fallback : value->get<std::string>();
}

std::optional<std::size_t> index_of(const Json* object, const char* name) {
  const Json* value = member(object, name);
  if (value == nullptr) return std::nullopt;
  return static_cast<std::size_t>(value->get<double>());
}

std::size_t size_of(const Json* object, const char* name) {
  const Json* value = member(object, name);
  return value == nullptr ? 0 : value->size();
}

const Json* element(const Json* object, const char* name, std::size_t index) {
  const Json* value = member(object, name);
  return value == nullptr || index >= value->size() ? nullptr : &(*value)[index];
}

const Json* extension(const Json* object, const char* name) {
  return member(member(object, "extensions"), name);
}

}  // namespace tessera::client::gltf
