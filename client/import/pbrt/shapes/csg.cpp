// The part of DirectiveHandler that makes combinations of solids: CSGBegin and CSGEnd, which are not pbrt's.
#include <cmath>

#include "import/input/concat.h"
#include "import/pbrt/directive_handler.h"
#include "wire/csg_limits.h"
#include "wire/enum_words.h"

namespace tessera::client::pbrt {

namespace {

/// Equal, but for what inverting and multiplying rounds.
bool nearly_equal(const Imath::M44d& a, const Imath::M44d& b) {
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) {
      if (!(std::abs(a[i][k] - b[i][k]) <= 1e-9 * (1 + std::abs(a[i][k])))) return false;
    }
  }
  return true;
}

}  // namespace

void DirectiveHandler::csg_begin(const std::string& operation, std::vector<Parameter> parameters,
                                 SourceLocation where) {
  if (!require_world("CSGBegin", where)) return;
  ParameterList all = list("CSGBegin", operation, std::move(parameters), where);
  ValueReader values(context_, textures_, all);
  const auto refuse = [&](const std::string& why) {
    context_.diagnostics.error(where, concat(all.owner(), ": ", why));
  };
  const auto known = wire::value_of<v1::Csg::Operation>(operation);
  if (!known.ok()) refuse(std::string(known.status().message()));
  const auto faces = wire::value_of<v1::Csg::CutFaces>(values.get_string("cutfaces", "cutter"));
  if (!faces.ok()) refuse(std::string(faces.status().message()));
  const auto group = [&](auto& message) {
    if (known.ok()) message.set_operation(*known);
    if (faces.ok()) message.set_cut_faces(*faces);
  };
  if (csg_depth_++ == 0) {
    begin_combination(concat(operation, " of solids"), where, group);
  } else if (csg_depth_ > wire::kMostCsgDepth) {
    refuse(concat("more than ", wire::kMostCsgDepth, " groups within one another"));
  } else {
    group(*combination_->add_parts()->mutable_begin());
  }
  blocks_.push_back({Block::Kind::kCsg, where, state_});
}

void DirectiveHandler::begin_combination(const std::string& what, SourceLocation where,
                                         const std::function<void(v1::Csg&)>& group) {
  close_curves();
  if (state_.has_area_light && current_object_ < 0)
    context_.diagnostics.error(where, "a combination of solids cannot emit light");
  v1::Shape message;
  PendingShape pending;
  pending.where = where;
  pending.needs.kept = true;
  const std::filesystem::path file = context_.diagnostics.file_name(where.file);
  message.set_name(concat(what, ", ", file.filename().string(), ":", where.line));
  group(*message.mutable_csg());
  write_state(message, pending);
  const std::optional<Imath::M44d> combination_from_world = inverse(state_.ctm.start);
  if (!combination_from_world)
    context_.diagnostics.error(where, "the transformation of a combination of solids is singular");
  combination_from_world_ = combination_from_world.value_or(Imath::M44d{});
  combination_to_world_ = state_.ctm;
  combination_media_ = {state_.inside_medium, state_.outside_medium};
  keep_shape(std::move(message), std::move(pending));
  combination_ = pending_shapes_.back().shape->mutable_csg();
}

void DirectiveHandler::csg_end(SourceLocation where) {
  if (blocks_.empty() || blocks_.back().kind != Block::Kind::kCsg) {
    context_.diagnostics.error(where, "CSGEnd without CSGBegin");
    return;
  }
  state_ = std::move(blocks_.back().saved);
  blocks_.pop_back();
  if (--csg_depth_ == 0) {
    combination_ = nullptr;
  } else if (csg_depth_ < wire::kMostCsgDepth) {
    combination_->add_parts()->set_end(true);
  }
}

void DirectiveHandler::keep_operand(v1::Shape message, PendingShape pending) {
  const auto refuse = [&](std::string_view why) {
    context_.diagnostics.error(pending.where, std::string(why));
  };
  if (state_.has_area_light && current_object_ < 0) refuse("a combination of solids cannot emit light");
  if (combination_media_ != std::pair(state_.inside_medium, state_.outside_medium))
    refuse("the medium interface of a combination of solids is that at its CSGBegin");
  const Imath::M44d operand = state_.ctm.start * combination_from_world_;
  if (state_.ctm.moves() && !nearly_equal(state_.ctm.end, operand * combination_to_world_.end))
    refuse("a combination of solids may move; its operands do not move within it");
  pending.object = current_object_;
  pending.material = state_.material;
  pending.world_from_object = {operand, operand};
  v1::Shape& kept = *combination_->add_parts()->mutable_solid();
  kept = std::move(message);
  pending.shape = &kept;
  pending.is_csg_operand = true;
  pending_shapes_.push_back(std::move(pending));
}

}  // namespace tessera::client::pbrt
