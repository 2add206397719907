// The part of DirectiveHandler that makes few shapes of many curves: hair has hundreds of thousands of
// directives.
#include "import/input/concat.h"
#include "import/pbrt/directive_handler.h"

namespace tessera::client::pbrt {

void DirectiveHandler::curve(ValueReader& values, SourceLocation where) {
  OpenCurves next;
  next.batch.kind = read_curve_kind(values);
  next.pending.where = where;
  next.pending.needs.kept = true;
  if (!append_curve(values, next.batch)) return;
  finish_shape(values, next.looks, next.pending.needs);
  write_state(next.looks, next.pending);

  const auto fits = [&](const OpenCurves& open) {
    const PendingShape &a = open.pending, &b = next.pending;
    const auto alpha = [](const v1::Shape& shape) {
      return shape.has_alpha() ? shape.alpha().constant() : 1.0f;
    };
    return open.batch.kind == next.batch.kind && a.object == b.object &&
           a.material.anonymous == b.material.anonymous && a.material.name == b.material.name &&
           a.world_from_object == b.world_from_object && a.needs.alpha_texture == b.needs.alpha_texture &&
           alpha(open.looks) == alpha(next.looks) &&
           open.looks.reverse_orientation() == next.looks.reverse_orientation() &&
           open.looks.interior_medium() == next.looks.interior_medium() &&
           open.looks.exterior_medium() == next.looks.exterior_medium() && !next.looks.has_area_light() &&
           open.batch.starts.size() + next.batch.starts.size() <= CurveBatch::kMaxSegments;
  };
  if (open_curves_ && fits(*open_curves_)) {
    append(next.batch, open_curves_->batch);
    return;
  }
  close_curves();
  open_curves_ = std::move(next);
}

void DirectiveHandler::close_curves() {
  if (!open_curves_) return;
  OpenCurves curves = *std::exchange(open_curves_, std::nullopt);
  write_curves(curves.batch, context_.blobs, *curves.looks.mutable_curves());
  const SourceLocation where = curves.pending.where;
  const std::filesystem::path file = context_.diagnostics.file_name(where.file);
  curves.looks.set_name(concat("curve, ", file.filename().string(), ":", where.line));
  keep_shape(std::move(curves.looks), std::move(curves.pending));
}

}  // namespace tessera::client::pbrt
