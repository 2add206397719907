#include "import/gltf/rules/accessor_uses.h"

#include <algorithm>

namespace tessera::client::gltf {
namespace {

constexpr std::int64_t kVertexTarget = 34962, kIndexTarget = 34963;  // bufferView.target

const char* text_of_usage(Usage usage) {
  switch (usage) {
    case Usage::kVertices:
      return "vertices";
    case Usage::kIndices:
      return "indices";
    case Usage::kInverseBindMatrices:
      return "inverse bind matrices";
    case Usage::kTimes:
      return "times of an animation";
    case Usage::kKeys:
      return "values of an animation";
  }
  return "";
}

}  // namespace

void AccessorUses::add(std::size_t accessor, Usage usage, const std::string& place) {
  const auto [known, is_new] = usages_.try_emplace(accessor, usage);
  if (known->second != usage)
    context_.error(place,
                   concat("accessor ", accessor, " is used for ", text_of_usage(known->second), " already"));
  const Json* json = element(&context_.document, "accessors", accessor);
  const auto view = index_of(json, "bufferView");
  if (!view) return;
  add_view(*view,
           usage == Usage::kVertices  ? ViewUsage::kVertices
           : usage == Usage::kIndices ? ViewUsage::kIndices
                                      : ViewUsage::kOther,
           place);
  const Json* view_json = element(&context_.document, "bufferViews", *view);
  if (usage != Usage::kVertices || member(view_json, "byteStride") != nullptr) return;
  const auto [tight, is_first] = tight_views_.try_emplace(*view, accessor);
  if (tight->second != accessor && extension(view_json, "EXT_meshopt_compression") == nullptr)
    context_.error(below("/bufferViews", *view), concat("accessors ", tight->second, " and ", accessor,
                                                        " have vertices in it, but it says no byteStride"));
}

void AccessorUses::add_other(std::size_t view, const std::string& place) {
  add_view(view, ViewUsage::kOther, place);
}

void AccessorUses::add_view(std::size_t view, ViewUsage usage, const std::string& place) {
  const Json* json = element(&context_.document, "bufferViews", view);
  const auto [known, is_new] = view_usages_.try_emplace(view, usage);
  if (known->second != usage) {
    context_.error(place, concat("bufferView ", view, " is used for something else already"));
    return;
  }
  if (!is_new) return;
  if (usage != ViewUsage::kVertices && member(json, "byteStride") != nullptr)
    context_.error(below(below("/bufferViews", view), "byteStride"), "only views of vertices have a stride");
  const std::int64_t target = integer_of(json, "target", 0);
  if ((target == kVertexTarget && usage != ViewUsage::kVertices) ||
      (target == kIndexTarget && usage != ViewUsage::kIndices))
    context_.error(below(below("/bufferViews", view), "target"),
                   concat("target ", target, " is not what the view is used for"));
}

}  // namespace tessera::client::gltf
