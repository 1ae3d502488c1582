# SPDX-License-Identifier: Apache-2.0
# The fuzzer, built by scripts/fuzz in a folder of its own: the readers and what they stand on, with clang's
# libFuzzer and sanitizers.
#   make -f ROOT/tests/fuzz/fuzz.mk ROOT=...
CC = clang
SAN = -fsanitize=address,undefined -fno-sanitize-recover=undefined
LIBS = libzip libpng libjpeg libcjson yajl yaml-0.1 zlib
CFLAGS = -std=gnu11 -g -O2 -fno-omit-frame-pointer -DPALMAR_LIBDIR='""' -DPALMAR_BINDIR='""' $(SAN) -I$(ROOT) -I. \
	$(shell pkg-config --cflags $(LIBS))
# Not what records a graph of an ONNX file: that stands on the whole library.
RECORDING = $(shell grep -l 'include "libtensor/io/onnx/import.h"' $(ROOT)/libtensor/io/onnx/*.c)
LIBTENSOR = $(filter-out $(RECORDING),$(wildcard $(ROOT)/libtensor/base/*.c $(ROOT)/libtensor/io/*.c $(ROOT)/libtensor/io/*/*.c))
GEOMETRY = $(addprefix $(ROOT)/libtensor/geometry/,lens.c mesh/kd_tree.c pose.c procrustes.c rotation.c svd3.c)
EVAL = $(addprefix $(ROOT)/eval/,metrics/metrics.c metrics/object_pose.c) \
	$(addprefix $(ROOT)/eval/scorers/,bop_file.c hpe_file.c models_info.c results_file.c) \
	$(addprefix $(ROOT)/assets/,body_file.c hand_file.c keyed_arrays.c ycb/symmetry.c ycb/ycb.c) \
	$(ROOT)/data/action/action.c $(ROOT)/data/body/rows.c \
	$(addprefix $(ROOT)/data/detection/,coco.c coco_folder.c detection.c labels.c polygon.c yolo.c) \
	$(addprefix $(ROOT)/data/ho3d/,points.c points_text.c) $(ROOT)/tasks/detect/results.c \
	$(addprefix $(ROOT)/data/mot/,rows.c sequence.c) \
	$(addprefix $(ROOT)/data/poses/,hoisdf.c palmar_frames.c palmar_poses.c pose_file.c) \
	$(addprefix $(ROOT)/pipeline/,boxes.c calibration/calibration.c calibration/tree.c)
READERS = $(LIBTENSOR) $(GEOMETRY) $(EVAL)
TARGETS = $(addprefix $(ROOT)/tests/fuzz/,mutate_pickle.c mutate_png.c mutate_zip.c seeds.c targets.c)
objects = $(patsubst $(ROOT)/%.c,%.o,$(1))
COMMON = $(call objects,$(READERS) $(TARGETS))

all: fuzz replay

fuzz: tests/fuzz/libfuzzer.o $(COMMON)
	$(CC) -fsanitize=fuzzer $(SAN) -o $@ $^ $(shell pkg-config --libs $(LIBS)) -ldl -lm

replay: tests/fuzz/replay.o $(COMMON)
	$(CC) $(SAN) -o $@ $^ $(shell pkg-config --libs $(LIBS)) -ldl -lm

# Comparisons are not traced: the mutators know the words, and it makes pickles three times slower.
$(call objects,$(READERS)): COVERAGE = -fsanitize-coverage=inline-8bit-counters,pc-table

# What configure would find out is of no matter here.
config.h:
	: >$@

$(COMMON) tests/fuzz/libfuzzer.o tests/fuzz/replay.o: %.o: $(ROOT)/%.c $(ROOT)/tests/fuzz/fuzz.mk config.h
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $(COVERAGE) -MMD -MP -c -o $@ $<

-include $(patsubst %.o,%.d,$(COMMON))
