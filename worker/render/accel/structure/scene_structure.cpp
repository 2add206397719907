#include "render/accel/structure/scene_structure.h"

#include <exception>
#include <type_traits>

#include "absl/strings/str_cat.h"
#include "render/core/stopped.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

namespace {

/// Figures of a tree, unless its folder has a figures_of() of its own.
template <class Tree>
StructureFigures figures_of(const Tree& tree) {
  return tree.figures;
}
template <class Node>
StructureFigures figures_of(const CellTree<Node>& tree) {
  return tree.figures();
}

}  // namespace

template <class Tree>
absl::Status TreeStructure<Tree>::build_level(const StructureOptions& options, Level<Tree>& level) {
  for (const Primitive& primitive : level.primitives) level.box.add(box_of(primitive));
  level.largest = level.primitives.empty() ? 0 : level.box.largest_coordinate();
  constexpr std::size_t kMostPrimitives = std::size_t{1} << 30;
  if (level.primitives.size() > kMostPrimitives) {
    return absl::ResourceExhaustedError(
        absl::StrCat(level.primitives.size(), " primitives in one structure; at most ", kMostPrimitives));
  }
  absl::Status built;
  with_structure(kind_, [&]<class Row>(const Row&) {
    if constexpr (std::is_same_v<typename Row::Tree, Tree>)
      built = Row::build(options, level.primitives, level.tree);
  });
  if (!built.ok()) return built;
  StructureFigures figures = figures_of(level.tree);
  figures.primitives = level.primitives.size();
  figures.bytes += sizeof(Primitive) * level.primitives.size();
  figures_.add(figures);
  return absl::OkStatus();
}

template <class Tree>
absl::Status TreeStructure<Tree>::build(const AnalyticBounds& analytic, const StructureOptions& options) {
  shadow_cache_ = options.shadow_cache;
  // At once: a list that grows is copied as a whole, which takes seconds where there are millions, and no
  // stop is looked for meanwhile.
  const auto reserve = [&](std::int32_t first_shape, std::int32_t shape_count, std::size_t instances,
                           std::vector<Primitive>& list) {
    std::size_t count = instances;
    for (std::int32_t s = first_shape; s < first_shape + shape_count; ++s)
      count += most_primitives(shapes_, s, analytic);
    list.reserve(count);
  };
  objects_.resize(shapes_.objects.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const ObjectRange& range = shapes_.objects[i];
    reserve(range.first_shape, range.shape_count, static_cast<std::size_t>(range.inner_count),
            objects_[i].primitives);
    for (std::int32_t s = 0; s < range.shape_count; ++s) {
      if (auto status =
              add_primitives(shapes_, range.first_shape + s, analytic, objects_[i].primitives, options.stop);
          !status.ok())
        return status;
    }
    for (std::int32_t k = range.first_inner; k < range.first_inner + range.inner_count; ++k) {
      const InstanceRecord& inner = shapes_.inner[static_cast<std::size_t>(k)];
      const Box& box = objects_[static_cast<std::size_t>(inner.object)].box;
      add_instance(k, box_of_instance(shapes_, inner, box), objects_[i].primitives);
    }
    if (auto status = build_level(options, objects_[i]); !status.ok()) return status;
  }
  inner_from_holder_.reserve(shapes_.inner.size());
  for (const InstanceRecord& inner : shapes_.inner)
    inner_from_holder_.push_back(inverse(exact(inner.render_from_instance)));
  reserve(0, shapes_.world_shape_count, shapes_.instances.size(), world_.primitives);
  for (std::int32_t s = 0; s < shapes_.world_shape_count; ++s) {
    if (auto status = add_primitives(shapes_, s, analytic, world_.primitives, options.stop); !status.ok())
      return status;
  }
  instance_from_render_.reserve(shapes_.instances.size());
  for (std::size_t i = 0; i < shapes_.instances.size(); ++i) {
    throw_if_stopped(options.stop, i);
    const InstanceRecord& instance = shapes_.instances[i];
    instance_from_render_.push_back(inverse(exact(instance.render_from_instance)));
    const Box& box = objects_[static_cast<std::size_t>(instance.object)].box;
    add_instance(static_cast<std::int32_t>(i), box_of_instance(shapes_, instance, box), world_.primitives);
  }
  if (auto status = build_level(options, world_); !status.ok()) return status;
  figures_.sah_cost = figures_of(world_.tree).sah_cost;
  figures_.bytes += sizeof(ExactAffine) * (instance_from_render_.size() + inner_from_holder_.size());
  // Half-spaces say nothing about the size of the scene; Embree's bounds leave them out, too.
  Box box;
  for (const Primitive& primitive : world_.primitives) {
    const bool unbounded =
        primitive.kind == PrimitiveKind::kInstance
            ? is_unbounded(shapes_, shapes_.instances[static_cast<std::size_t>(primitive.number)])
            : is_unbounded(shapes_.shapes[static_cast<std::size_t>(primitive.shape)]);
    if (!unbounded) box.add(box_of(primitive));
  }
  if (!box.empty()) {
    for (int k = 0; k < 3; ++k) centre_[k] = box.centre(k);
    radius_ = 0.5f * std::hypot(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]);
  }
  return absl::OkStatus();
}

namespace {

template <class Tree>
absl::StatusOr<std::unique_ptr<SceneStructure>> build_of(StructureKind kind, const ShapeTable& shapes,
                                                         const TextureTable& textures,
                                                         const AnalyticBounds& analytic,
                                                         const StructureOptions& options) {
  auto structure = std::make_unique<TreeStructure<Tree>>(kind, shapes, textures);
  try {
    if (auto s = structure->build(analytic, options); !s.ok()) return s;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("building the acceleration structure: out of memory");
  }
  return structure;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SceneStructure>> build_structure(StructureKind kind, const ShapeTable& shapes,
                                                                const TextureTable& textures,
                                                                const AnalyticBounds& analytic,
                                                                const StructureOptions& options) {
  absl::StatusOr<std::unique_ptr<SceneStructure>> structure = absl::InvalidArgumentError("no such structure");
  with_structure(kind, [&]<class Row>(const Row&) {
    structure = build_of<typename Row::Tree>(kind, shapes, textures, analytic, options);
  });
  return structure;
}

}  // namespace tessera::render
