// CNF-9: `fba-decoder INPUT`. Exit 0: accepted, 1: rejected (one JSON line on standard error), 2: usage, 3: files.
package main

import (
	"encoding/json"
	"fmt"
	"os"
)

func main() {
	if len(os.Args) != 2 {
		fmt.Fprintln(os.Stderr, "usage: fba-decoder INPUT")
		os.Exit(2)
	}
	data, err := os.ReadFile(os.Args[1])
	if err == nil {
		var found *fault
		found, err = decodeStream(data, os.Stdout)
		if err == nil && found != nil {
			text, _ := json.Marshal(found) // a struct of strings and numbers always has a JSON form
			fmt.Fprintln(os.Stderr, string(text))
			os.Exit(1)
		}
	}
	if err != nil {
		fmt.Fprintln(os.Stderr, "fba-decoder:", err)
		os.Exit(3)
	}
}
