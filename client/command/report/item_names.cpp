#include "command/report/item_names.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera::client {

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;

class Names {
 public:
  /// The next `count` numbers have this name.
  void add(const std::string& name, std::uint64_t count = 1) {
    for (std::uint64_t i = 0; i < count && !too_many(); ++i) {
      ++number_;
      if (name.empty()) continue;
      json_[std::to_string(number_)] = name;
      least_bytes_ += name.size();
    }
  }
  void put(const char* attribute, Image& image) const {
    if (too_many()) return;
    // Names are what the author wrote, in whatever encoding.
    std::string text = json_.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
    if (text.size() <= kMostBytes) image.metadata[attribute] = std::move(text);
  }

 private:
  /// Whether the text would be too long: an entry has two pairs of quotes, a number, a colon and a comma.
  bool too_many() const { return least_bytes_ + 7 * json_.size() > kMostBytes; }

  std::size_t least_bytes_ = 0;
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
  for (const auto& run : scene.packed_instances().runs()) instances.add(run.object(), run.count());
  shapes.put("tessera.shapes", image);
  instances.put("tessera.instances", image);
}

}  // namespace tessera::client
