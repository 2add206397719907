#include "command/report/item_names.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera::client {

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;

class Names {
 public:
  /// The next number has this name.
  void add(const std::string& name) {
    ++number_;
    if (!name.empty()) json_[std::to_string(number_)] = name;
  }
  void put(const char* attribute, Image& image) const {
    // Names are what the author wrote, in whatever encoding.
    std::string text = json_.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
    if (text.size() <= kMostBytes) image.metadata[attribute] = std::move(text);
  }

 private:
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
  int number_ = 0;
};

}  // namespace

void add_item_names(const v1::Scene& scene, const v1::JobSpec& spec, Image& image) {
  const auto& aovs = spec.view().aovs();
  if (std::find(aovs.begin(), aovs.end(), v1::AOV_ID) == aovs.end()) return;
  Names shapes, instances;
  for (const v1::Shape& shape : scene.shapes()) shapes.add(shape.name());
  for (const v1::Object& object : scene.objects()) {
    for (const v1::Shape& shape : object.shapes()) shapes.add(shape.name());
  }
  for (const v1::Instance& instance : scene.instances()) instances.add(instance.object());
  shapes.put("tessera.shapes", image);
  instances.put("tessera.instances", image);
}

}  // namespace tessera::client
