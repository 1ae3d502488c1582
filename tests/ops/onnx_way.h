/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One case of an op's suite as an ONNX file and back: the same values.
 */
#ifndef TESTS_OPS_ONNX_WAY_H
#define TESTS_OPS_ONNX_WAY_H

#include "tests/ops/suite.h"

/* check_onnx_way - fails for an op without an ONNX form, unless it may be without */
void check_onnx_way(const op_suite *s, const op_case *c);

#endif
