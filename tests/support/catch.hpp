#pragma once
// Catch2 2.13 (Debian's), with the matchers tests use.

#include <catch2/catch.hpp>

using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
