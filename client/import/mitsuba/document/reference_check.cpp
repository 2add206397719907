#include "import/mitsuba/document/reference_check.h"

#include <algorithm>
#include <unordered_map>

#include "import/input/concat.h"

namespace tessera::client::mitsuba {
namespace {

// Deeper than any scene; what reads the objects may recurse this far.
constexpr std::size_t kMaxDepth = 150;

/// Walks the objects below the root depth first, without recursion.
class CycleCheck {
 public:
  explicit CycleCheck(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  void run(Object& root) {
    enter(root);
    while (!path_.empty()) {
      Step& step = path_.back();
      if (step.next == step.object->properties.size()) {
        finish();
        continue;
      }
      Property& property = step.object->properties[step.next++];
      Object** child = std::get_if<Object*>(&property.value);
      if (child == nullptr || *child == nullptr) continue;
      visit(property, **child);
    }
  }

 private:
  struct Step {
    Object* object;
    std::size_t next = 0;    // property
    std::size_t height = 0;  // height of the objects below, so far
  };

  void visit(Property& property, Object& child) {
    const auto known = height_.find(&child);
    std::string problem;
    if (known != height_.end() && known->second == kInProgress) {
      problem = concat("the ", child.title(), " contains itself");
    } else if (path_.size() + (known == height_.end() ? 0 : known->second) >= kMaxDepth) {
      problem = concat("objects are nested more than ", kMaxDepth, " deep");
    }
    if (!problem.empty()) {
      diagnostics_.error(property.where, problem);
      property.value = static_cast<Object*>(nullptr);
    } else if (known == height_.end()) {
      enter(child);
    } else {
      path_.back().height = std::max(path_.back().height, known->second + 1);
    }
  }

  void enter(Object& object) {
    height_[&object] = kInProgress;
    path_.push_back({&object});
  }

  void finish() {
    const std::size_t height = path_.back().height;
    height_[path_.back().object] = height;
    path_.pop_back();
    if (!path_.empty()) path_.back().height = std::max(path_.back().height, height + 1);
  }

  static constexpr std::size_t kInProgress = static_cast<std::size_t>(-1);
  Diagnostics& diagnostics_;
  std::vector<Step> path_;
  std::unordered_map<const Object*, std::size_t> height_;
};

}  // namespace

void resolve_references(const std::vector<Reference>& references, const std::map<std::string, Object*>& ids,
                        Document& document, Diagnostics& diagnostics) {
  for (const Reference& reference : references) {
    // The place in the file tells properties without a name apart.
    const auto property = std::find_if(
        reference.owner->properties.begin(), reference.owner->properties.end(), [&](const Property& p) {
          const Object* const* object = std::get_if<Object*>(&p.value);
          return object != nullptr && *object == nullptr && p.name == reference.name &&
                 p.where.file == reference.where.file && p.where.line == reference.where.line &&
                 p.where.column == reference.where.column;
        });
    if (property == reference.owner->properties.end()) continue;
    const auto target = ids.find(reference.id);
    if (target == ids.end()) {
      diagnostics.error(reference.where, concat("there is no object with the id \"", reference.id, "\""));
    } else {
      property->value = target->second;
    }
  }
  if (document.root != nullptr) CycleCheck(diagnostics).run(*document.root);
  // Objects that could not be resolved must not be looked at.
  for (Object& object : document.objects) {
    std::erase_if(object.properties, [](const Property& p) {
      const Object* const* child = std::get_if<Object*>(&p.value);
      return child != nullptr && *child == nullptr;
    });
  }
}

}  // namespace tessera::client::mitsuba
