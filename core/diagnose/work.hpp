#pragma once
// What one diagnosis works on, from step to step; of this folder alone.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnose/diagnose.hpp"
#include "core/diagnose/dictionary.hpp"
#include "core/diagnose/residual_space.hpp"
#include "core/diagnose/selection.hpp"
#include "core/model/history.hpp"

namespace trammel {

struct Work {
  const Campaign& campaign;
  const DiagnoseOptions& options;
  Diagnosis out = {};
  std::shared_ptr<const History> history = {};
  std::vector<Reading> readings;  // identify, without the bad ones
  GeometryFit base = {};
  ResidualSpace space = {};        // around the base
  std::vector<Shape> shapes = {};  // dictionary and catalogue
  Library library = {};
  bool agreement_taken = false;              // agreement of successive readings was taken for noise
  std::optional<double> one_length_mm = {};  // of all approaches, where it is one
  std::vector<int> certain = {};             // seqs that are wrong whatever the model is
};

/// Readings of a set: measured ones, and rows to predict.
std::vector<Reading> of_set(const Campaign& campaign, ReadingSet set);

/// The base, and what it leaves, with the noise as it stands.
void fit_base(Work& w);

/// Everything that structure is looked for with: shapes without a name, and the catalogue's own.
void make_shapes(Work& w, const ResidualSpace& space);

/// One calibrated p for all shapes on the residuals of `space`. The null of noise with heavy tails
/// is that noise, not a normal distribution's: the readings' own residuals, exchanged.
StructureTest test(const Work& w, const ResidualSpace& space, double level);

/// "0.00123", three digits.
std::string text_of(double value);

}  // namespace trammel
