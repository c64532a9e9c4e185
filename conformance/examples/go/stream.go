package main

import (
	"bufio"
	"encoding/json"
	"io"
	"math/big"
)

const (
	maxSkipped = 1000000
	maxIdle    = 1024
)

type visemeLine struct {
	Select1 int64 `json:"select1"`
	Select2 int64 `json:"select2"`
	Blend   int64 `json:"blend"`
	Def     int   `json:"def"`
}

type expressionLine struct {
	Select1    int64 `json:"select1"`
	Intensity1 int64 `json:"intensity1"`
	Select2    int64 `json:"select2"`
	Intensity2 int64 `json:"intensity2"`
	InitFace   int   `json:"init_face"`
	Def        int   `json:"def"`
}

// frameLine is CNF-1.
type frameLine struct {
	Index      int             `json:"index"`
	Time       string          `json:"time"`
	Intra      bool            `json:"intra"`
	Faps       [68]*int64      `json:"faps"`
	Viseme     *visemeLine     `json:"viseme"`
	Expression *expressionLine `json:"expression"`
	State      string          `json:"state"`
	Baps       *map[int]int64  `json:"baps,omitempty"`
}

// decodeStream writes the decoded lines; the fault is nil for an accepted stream.
func decodeStream(data []byte, to io.Writer) (found *fault, err error) {
	out := bufio.NewWriter(to)
	defer func() {
		if value := recover(); value != nil {
			f, ok := value.(*fault)
			if !ok {
				panic(value)
			}
			found = f
		}
		if flushed := out.Flush(); err == nil {
			err = flushed
		}
	}()
	r := newReader(data)
	findObject(r)
	if _, err := out.WriteString(`{"format":"snhc-decoded","version":1,"kind":"fba"}` + "\n"); err != nil {
		return nil, err
	}
	o := &object{r: r, face: newFace(), body: newBody(), time: new(big.Rat), period: big.NewRat(1, 30)}
	lines := json.NewEncoder(out)
	for index, idle := 0, 0; ; index++ {
		more, startCode := o.boundary(index == 0)
		if !more {
			return nil, nil
		}
		start := r.pos
		line, empty := o.plane()
		if !empty {
			idle = 0
		} else if startCode {
			idle = 1
		} else if idle++; idle > maxIdle {
			reject("ResourceLimit", "FBA-42", start, r.pos)
		}
		line.Index = index
		if err := lines.Encode(line); err != nil {
			return nil, err
		}
	}
}

// nextCode reads the next start code that is not user data (SYS-5).
func nextCode(r *reader) uint32 {
	for {
		start := r.pos
		code := r.u(32, "SYS-1")
		if code != 0x1B2 {
			return code
		}
		for !r.is(r.pos, 24, 1) {
			if r.pos+24 >= r.end {
				reject("Truncated", "SYS-5", start, r.end)
			}
			r.pos += 8
		}
	}
}

// sequence reads up to the first visual object start code (SYS-2).
func sequence(r *reader) {
	for {
		r.u(8, "SYS-2")
		code := nextCode(r)
		if code == 0x1B5 {
			return
		}
		if code != 0x1B1 || !r.is(r.pos, 32, 0x1B0) {
			r.rejectLast("InconsistentSemantics", "SYS-2", 32)
		}
		r.pos += 32 // a sequence without objects, and another one behind it
	}
}

// findObject is SYS-1..7; it ends behind the object start code.
func findObject(r *reader) {
	if r.end < 32 {
		reject("InputFormat", "FBA-44", 0, r.end)
	}
	switch first := r.u(32, "FBA-1"); first {
	case 0x1BA:
		return
	case 0x1BC:
		r.rejectLast("Unsupported", "SYS-7", 32)
	case 0x1B0:
	case 0x1B1, 0x1B2, 0x1B5, 0x1BB, 0x1BD:
		r.rejectLast("InconsistentSemantics", "SYS-7", 32)
	default:
		if first == 0x1BE || first>>8 == 1 && first&0xFF <= 0x2F {
			r.rejectLast("Unsupported", "SYS-4", 32)
		}
		r.rejectLast("InputFormat", "FBA-1", 32)
	}
	sequence(r)
	if r.flag("SYS-3") {
		r.u(4, "SYS-3")
		if r.u(3, "SYS-3") == 0 {
			r.rejectLast("ReservedValue", "SYS-3", 3)
		}
	}
	kind := r.u(4, "SYS-4")
	switch {
	case kind == 0 || kind > 5:
		r.rejectLast("ReservedValue", "SYS-4", 4)
	case kind != 3 && kind != 4:
		r.rejectLast("Unsupported", "SYS-4", 4)
	}
	behind, exact := r.stuffed()
	if !exact {
		reject("ForbiddenValue", "SYS-3", r.pos, behind)
	}
	r.pos = behind
	code := nextCode(r)
	if kind == 4 && code != 0x1BA || kind == 3 && code != 0x1BC {
		r.rejectLast("InconsistentSemantics", "SYS-6", 32)
	}
	if kind == 3 {
		r.rejectLast("Unsupported", "SYS-4", 32)
	}
}

type object struct {
	r      *reader
	face   *face
	body   *body
	time   *big.Rat
	period *big.Rat
}

// boundary is FBA-3, FBA-42, FBA-44: whether a plane follows, and whether a start code announced it.
func (o *object) boundary(first bool) (more, startCode bool) {
	r := o.r
	if r.pos >= r.content {
		return false, false
	}
	if behind, exact := r.stuffed(); exact {
		switch {
		case behind == r.end:
			return false, false
		case r.is(behind, 24, 1) && behind+24 == r.end:
			reject("Truncated", "FBA-44", behind, r.end)
		case r.is(behind, 32, 0x1BB):
			r.pos = behind + 32
			return true, true
		case r.is(behind, 24, 1):
			return false, false
		}
	}
	if first && r.is(r.pos, 32, 0x1BB) {
		r.pos += 32
		return true, true
	}
	return true, false
}

// plane is FBA-5, FBA-35.
func (o *object) plane() (line *frameLine, empty bool) {
	r := o.r
	start := r.pos
	intra := r.flag("FBA-5")
	mask := r.u(2, "FBA-5")
	hasFaps, hasBaps := mask&1 != 0, mask&2 != 0
	if !intra && (hasFaps && !o.face.seen || hasBaps && !o.body.seen) {
		reject("InconsistentSemantics", "FBA-35", start, start+1)
	}
	line = &frameLine{Intra: intra, Time: o.temporalHeader(intra)}
	if hasFaps {
		o.face.data(r, intra)
	} else {
		o.face.noData()
	}
	if hasBaps {
		o.body.data(r, intra)
		baps := make(map[int]int64, len(o.body.coded))
		for _, n := range o.body.coded {
			baps[n] = o.body.baps[n].value
		}
		line.Baps = &baps
	}
	o.fill(line)
	return line, mask == 0
}

// temporalHeader is FBA-6..8, FBA-37, FBA-38. It gives the plane's time; the running time goes on.
func (o *object) temporalHeader(intra bool) string {
	r := o.r
	if intra && r.flag("FBA-6") {
		rate := int64(r.u(8, "FBA-6")) << 4
		rate += int64(r.u(4, "FBA-6"))
		offset := r.flag("FBA-6")
		if rate == 0 {
			r.rejectLast("ForbiddenValue", "FBA-37", 13)
		}
		o.period.SetFrac64(16, rate)
		if offset {
			o.period.Mul(o.period, big.NewRat(1001, 1000))
		}
	}
	if intra && r.flag("FBA-7") {
		hours := r.upTo(5, 23, "FBA-7")
		minutes := r.upTo(6, 59, "FBA-7")
		r.marker("FBA-7")
		seconds := r.upTo(6, 59, "FBA-7")
		o.time.SetInt64(int64(3600*hours + 60*minutes + seconds))
	}
	periods := int64(1)
	if r.flag("FBA-8") {
		for start, more := r.pos, true; more; {
			part := r.u(4, "FBA-8")
			periods += int64(part)
			if periods-1 > maxSkipped {
				reject("ResourceLimit", "FBA-8", start, r.pos)
			}
			more = part == 15
		}
	}
	now := o.time.String()
	o.time.Add(o.time, new(big.Rat).Mul(o.period, new(big.Rat).SetInt64(periods)))
	return now
}

func (o *object) fill(line *frameLine) {
	f := o.face
	line.State = string(f.state[1:])
	for n := 3; n <= 68; n++ {
		if f.has(n) {
			value := f.low[n].value
			line.Faps[n-1] = &value
		}
	}
	if f.has(1) {
		line.Viseme = &visemeLine{f.viseme[0].value, f.viseme[1].value, f.viseme[2].value, f.visemeDef}
	}
	if f.has(2) {
		e := &f.expression
		line.Expression = &expressionLine{e[0].value, e[1].value, e[2].value, e[3].value, f.initFace, f.expressionDef}
	}
}
